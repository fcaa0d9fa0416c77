// SPDX-License-Identifier: Apache-2.0
#include "app/uds_server.hpp"

#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "base/boot_request.hpp"
#include "base/diagnostic_address.hpp"
#include "can_dbc/car.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using app::IsoTp;
using app::UdsRestart;
using app::UdsServer;
using Bytes = std::vector<std::uint8_t>;

namespace {

constexpr std::uint32_t kToNode = diagnostic_id(kBmsAddress, kTesterAddress);
constexpr std::uint32_t kFromNode = diagnostic_id(kTesterAddress, kBmsAddress);

Frame frame_of(const Bytes& bytes, std::uint32_t id = kToNode) {
  Frame f;
  f.id = id;
  f.dlc = static_cast<std::uint8_t>(bytes.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) f.data[i] = bytes[i];
  return f;
}

}  // namespace

TEST_GROUP(UdsServer) {
  UdsServer server{kBmsAddress, {"0.1.0", "bms_node_stm32f4"}};
  app::UdsView view{0, 0, true};
  std::uint32_t now_ms = 0;
  Bytes flow = {0x30, 0, 0};  ///< what the tester answers to a first frame

  std::vector<Frame> tick(const std::vector<Frame>& rx = {}) {
    TxQueue tx;
    server.tick(Instant::from_ms(now_ms), {rx.data(), rx.size()}, view, tx);
    now_ms += 10;
    CHECK(tx.size() <= IsoTp::kFramesPerTick);
    std::vector<Frame> out(tx.begin(), tx.end());
    for (const Frame& f : out) UNSIGNED_LONGS_EQUAL(kFromNode, f.id);
    return out;
  }
  /// A tester: sends a request in as many frames as it takes, and puts the answer together.
  Bytes ask(const Bytes& request, int* ticks = nullptr) {
    std::vector<Frame> answer;
    if (request.size() <= 7) {
      Bytes single = {static_cast<std::uint8_t>(request.size())};
      single.insert(single.end(), request.begin(), request.end());
      answer = tick({frame_of(single)});
    } else {
      Bytes first = {static_cast<std::uint8_t>(0x10 | request.size() >> 8), static_cast<std::uint8_t>(request.size())};
      first.insert(first.end(), request.begin(), request.begin() + 6);
      const auto control = tick({frame_of(first)});
      if (control.size() != 1 || control[0].data[0] != 0x30) return {};
      std::uint8_t number = 1;
      for (std::size_t at = 6; at < request.size(); at += 7) {
        Bytes next = {static_cast<std::uint8_t>(0x20 | (number++ & 0xF))};
        for (std::size_t i = at; i < std::min(at + 7, request.size()); ++i) next.push_back(request[i]);
        answer = tick({frame_of(next)});
      }
    }
    return collect(answer, ticks);
  }
  Bytes collect(std::vector<Frame> frames, int* ticks = nullptr) {
    Bytes out;
    std::size_t length = 0;
    for (int t = 0; t < 200; ++t) {
      std::vector<Frame> reply;
      for (const Frame& f : frames) {
        const unsigned kind = f.data[0] >> 4;
        if (kind == 0) return Bytes(f.data + 1, f.data + 1 + (f.data[0] & 0xF));
        if (kind == 1) {
          length = (f.data[0] & 0xFU) << 8 | f.data[1];
          out.assign(f.data + 2, f.data + 8);
          reply.push_back(frame_of(flow));
        }
        if (kind == 2) out.insert(out.end(), f.data + 1, f.data + 8);
      }
      if (ticks != nullptr) *ticks = t;
      if (length != 0 && out.size() >= length) {
        out.resize(length);
        return out;
      }
      frames = tick(reply);
    }
    return out;
  }
  static std::string text(const Bytes& b, std::size_t from) {
    return std::string(b.begin() + static_cast<long>(from), b.end());
  }
};

// DIA-001
TEST(UdsServer, TheSoftwareVersionAndTheNameOfTheImageAreTold) {
  const Bytes version = ask({0x22, 0xF1, 0x89});
  CHECK((version == Bytes{0x62, 0xF1, 0x89, '0', '.', '1', '.', '0'}));
  const Bytes image = ask({0x22, 0xF1, 0x95});
  CHECK_EQUAL(std::string("bms_node_stm32f4"), text(image, 3));
  const Bytes both = ask({0x22, 0xF1, 0x89, 0xF1, 0x86, 0x12, 0x34});
  CHECK((both == Bytes{0x62, 0xF1, 0x89, '0', '.', '1', '.', '0', 0xF1, 0x86, 0x01}));
  CHECK((ask({0x22, 0xF1, 0x86}) == Bytes{0x62, 0xF1, 0x86, 0x01}));  // and nothing of the request before
  Bytes many = {0x22};
  for (int i = 0; i < 8; ++i) many.insert(many.end(), {0xF1, 0x89});  // 17 bytes: a request in several frames
  LONGS_EQUAL(1 + 8 * 7, ask(many).size());
}

// DIA-001
TEST(UdsServer, AnAnswerThatJustFitsIsGivenAndOneByteMoreIsRefused) {
  const auto answer_to = [this](int sessions, int versions) {
    Bytes request = {0x22};
    for (int i = 0; i < 8; ++i) request.insert(request.end(), {0xF1, 0x95});  // 18 bytes each
    for (int i = 0; i < versions; ++i) request.insert(request.end(), {0xF1, 0x89});  // 7
    for (int i = 0; i < sessions; ++i) request.insert(request.end(), {0xF1, 0x86});  // 3
    return ask(request);
  };
  const Bytes whole = answer_to(5, 0);
  LONGS_EQUAL(IsoTp::kResponseMost, whole.size());
  CHECK((Bytes(whole.end() - 3, whole.end()) == Bytes{0xF1, 0x86, 0x01}));
  CHECK((answer_to(3, 1) == Bytes{0x7F, 0x22, 0x14}));
  LONGS_EQUAL(IsoTp::kResponseMost, answer_to(5, 0).size());
}

// DIA-002
TEST(UdsServer, FaultsAreToldWithWhatIsSetNowAndWhatIsLatched) {
  CHECK((ask({0x19, 0x02, 0xFF}) == Bytes{0x59, 0x02, 0x09}));
  view.faults_now = 1U << 4 | 1U << 20;  // a code is one below its bit
  view.faults_latched = 1U << 4 | 1U << 8;
  CHECK((ask({0x19, 0x01, 0x09}) == Bytes{0x59, 0x01, 0x09, 0x01, 0x00, 0x03}));
  CHECK((ask({0x19, 0x01, 0x01}) == Bytes{0x59, 0x01, 0x09, 0x01, 0x00, 0x02}));
  CHECK((ask({0x19, 0x02, 0x09}) ==
         Bytes{0x59, 0x02, 0x09, 0x1A, 3, 0, 0x09, 0x1A, 7, 0, 0x08, 0x1A, 19, 0, 0x09}));
  LONGS_EQUAL(3 + 4 * 21, ask({0x19, 0x0A}).size());
}

// DIA-006
TEST(UdsServer, TheMasterAnswersAtItsOwnAddressWithItsOwnCodesAndIsDeafToWhatTheBmsIsAsked) {
  UdsServer master{kMasterAddress, {"0.1.0", "master_node", app::kMasterFaults}};
  const app::UdsView seen{1U << 4 | 1U << 15, 1U << 0, false};
  const auto answer_to = [&](std::uint8_t address, const Bytes& request) {
    const Frame frame = frame_of(request, diagnostic_id(address, kTesterAddress));
    TxQueue tx;
    master.tick(Instant::from_ms(now_ms += 10), {&frame, 1}, seen, tx);
    return std::vector<Frame>(tx.begin(), tx.end());
  };
  CHECK(answer_to(kBmsAddress, {3, 0x19, 0x01, 0xFF}).empty());
  const auto count = answer_to(kMasterAddress, {3, 0x19, 0x01, 0xFF});
  LONGS_EQUAL(1, count.size());
  UNSIGNED_LONGS_EQUAL(diagnostic_id(kTesterAddress, kMasterAddress), count[0].id);
  CHECK((Bytes(count[0].data, count[0].data + 7) == Bytes{6, 0x59, 0x01, 0x09, 0x01, 0x00, 0x03}));
  const auto first = answer_to(kMasterAddress, {3, 0x19, 0x02, 0x08});
  LONGS_EQUAL(1, first.size());
  CHECK((Bytes(first[0].data + 1, first[0].data + 8) == Bytes{3 + 4 * 3, 0x59, 0x02, 0x09, 0x1B, 0, 0}));
  const auto reset = answer_to(kMasterAddress, {2, 0x11, 0x01});
  LONGS_EQUAL(1, reset.size());
  CHECK((Bytes(reset[0].data, reset[0].data + 4) == Bytes{3, 0x7F, 0x11, 0x22}));
}

TEST(UdsServer, EveryBitOfANodesFaultsHasItsCode) {
  for (const app::UdsFaults& faults : {app::kBmsFaults, app::kMasterFaults}) {
    UdsServer node{kBmsAddress, {"0.1.0", "x", faults}};
    const Frame frame = frame_of({2, 0x19, 0x0A});
    TxQueue tx;
    node.tick(Instant::from_ms(now_ms += 10), {&frame, 1}, view, tx);
    LONGS_EQUAL(1, tx.size());
    LONGS_EQUAL(3 + 4 * faults.count, tx[0].data[1]);
  }
}

// DIA-002: testers and record books of before the bit of isolation keep their codes.
TEST(UdsServer, ACodeIsTheSameWhateverBitItsFaultHas) {
  const auto code_of = [&](can::BmsFault fault) {
    view.faults_now = std::uint32_t{1} << static_cast<unsigned>(fault);
    const Bytes answer = ask({0x19, 0x02, 0x01});
    LONGS_EQUAL(3 + 4, answer.size());
    return static_cast<int>(answer[4]);
  };
  LONGS_EQUAL(0, code_of(can::BmsFault::kCellVoltageLow));
  LONGS_EQUAL(8, code_of(can::BmsFault::kPrechargeTimeout));
  LONGS_EQUAL(19, code_of(can::BmsFault::kTemperatureImplausible));
  LONGS_EQUAL(20, code_of(can::BmsFault::kIsolationFault));
}

// DIA-003
TEST(UdsServer, ResetAndBootLoaderComeAfterTheAnswerAndNeverWithClosedContactors) {
  view.may_restart = false;
  CHECK((ask({0x11, 0x01}) == Bytes{0x7F, 0x11, 0x22}));
  CHECK((ask({0x10, 0x02}) == Bytes{0x7F, 0x10, 0x22}));
  tick();
  CHECK(server.restart() == UdsRestart::kNone);
  view.may_restart = true;
  CHECK((ask({0x11, 0x01}) == Bytes{0x51, 0x01}));
  CHECK(server.restart() == UdsRestart::kNone);  // the answer goes out first
  view.may_restart = false;                       // a contactor closes meanwhile
  tick();
  CHECK(server.restart() == UdsRestart::kNone);
  view.may_restart = true;
  tick();
  CHECK(server.restart() == UdsRestart::kNone);
  CHECK((ask({0x10, 0x02}) == Bytes{0x50, 0x02, 0x00, 0x32, 0x01, 0xF4}));
  tick();
  CHECK(server.restart() == UdsRestart::kBootLoader);
}

// DIA-003
TEST(UdsServer, ResetIsAReset) {
  CHECK((ask({0x11, 0x01}) == Bytes{0x51, 0x01}));
  tick();
  CHECK(server.restart() == UdsRestart::kReset);
}

// DIA-003
TEST(UdsServer, TheDefaultSessionIsEnteredAnyTimeAndRestartsNothing) {
  for (const bool may_restart : {false, true}) {
    view.may_restart = may_restart;
    CHECK((ask({0x10, 0x01}) == Bytes{0x50, 0x01, 0x00, 0x32, 0x01, 0xF4}));
    tick();
    CHECK(server.restart() == UdsRestart::kNone);
  }
}

// A wrong length is told before anything else of the request counts.
TEST(UdsServer, ARequestThatIsTooShortOrTooLongIsRefused) {
  for (const Bytes& right : {Bytes{0x10, 0x02}, Bytes{0x11, 0x01}, Bytes{0x3E, 0x00}, Bytes{0x19, 0x0A},
                             Bytes{0x19, 0x02, 0x09}, Bytes{0x19, 0x01, 0x09}, Bytes{0x22, 0xF1, 0x89}}) {
    const Bytes refusal = {0x7F, right[0], 0x13};
    Bytes longer = right;
    longer.push_back(0x00);
    CHECK((ask(longer) == refusal));
    CHECK((ask(right)[0] == right[0] + 0x40));
    view.may_restart = false;  // takes back what was asked for
    tick();
    view.may_restart = true;
    for (Bytes shorter = right; shorter.size() > 1;) {
      shorter.pop_back();
      if (shorter == Bytes{0x19, 0x0A}) continue;
      CHECK((ask(shorter) == refusal));
    }
    tick();
    CHECK(server.restart() == UdsRestart::kNone);
  }
}

TEST(UdsServer, WhatItCannotAnswerIsRefusedWithItsCode) {
  CHECK((ask({0x27, 0x01}) == Bytes{0x7F, 0x27, 0x11}));
  CHECK((ask({0x22, 0x12, 0x34}) == Bytes{0x7F, 0x22, 0x31}));
  CHECK((ask({0x22, 0xF1}) == Bytes{0x7F, 0x22, 0x13}));
  CHECK((ask({0x22}) == Bytes{0x7F, 0x22, 0x13}));
  CHECK((ask({0x19, 0x55}) == Bytes{0x7F, 0x19, 0x12}));
  CHECK((ask({0x19}) == Bytes{0x7F, 0x19, 0x13}));  // the function of before does not count
  CHECK((ask({0x19, 0x02}) == Bytes{0x7F, 0x19, 0x13}));
  CHECK((ask({0x10, 0x07}) == Bytes{0x7F, 0x10, 0x12}));
  CHECK((ask({0x3E, 0x01}) == Bytes{0x7F, 0x3E, 0x12}));
  Bytes many = {0x22};
  for (int i = 0; i < 30; ++i) many.insert(many.end(), {0xF1, 0x95});
  CHECK((ask(many) == Bytes{0x7F, 0x22, 0x14}));
}

TEST(UdsServer, ThePositiveAnswerIsLeftOutWhenItIsAskedTo) {
  CHECK((ask({0x3E, 0x00}) == Bytes{0x7E, 0x00}));
  CHECK(tick({frame_of({0x02, 0x3E, 0x80})}).empty());
  CHECK((ask({0x11, 0x82}) == Bytes{0x7F, 0x11, 0x12}));
  CHECK(tick({frame_of({0x03, 0x19, 0x81, 0x09})}).empty());
  CHECK(tick({frame_of({0x02, 0x10, 0x81})}).empty());
  CHECK(server.restart() == UdsRestart::kNone);
  CHECK(tick({frame_of({0x02, 0x11, 0x81})}).empty());
  CHECK(server.restart() == UdsRestart::kReset);  // the answer that it has left out need not go first
  CHECK(tick({frame_of({0x02, 0x10, 0x82})}).empty());
  CHECK(server.restart() == UdsRestart::kBootLoader);
}

TEST(UdsServer, FlowControlOfTheTesterIsKept) {
  int fast = 0, slow = 0;
  ask({0x19, 0x0A}, &fast);
  flow = {0x30, 0, 50};
  const std::uint32_t before = now_ms;
  LONGS_EQUAL(87, ask({0x19, 0x0A}, &slow).size());
  CHECK(now_ms - before >= 11 * 50);
  CHECK(fast <= 13);
  flow = {0x32, 0, 0};  // overflow: given up
  CHECK(ask({0x19, 0x0A}).size() < 87);
  flow = {0x30, 0, 0};
  LONGS_EQUAL(87, ask({0x19, 0x0A}).size());
}

TEST(UdsServer, ATesterThatFallsSilentIsGivenUpAfterASecond) {
  tick({frame_of({0x02, 0x19, 0x0A})});
  for (int i = 0; i < 101; ++i) CHECK(tick().empty());
  CHECK(tick({frame_of({0x30, 0, 0})}).empty());
  tick({frame_of({0x10, 0x14, 0x22, 0xF1, 0x89, 0xF1, 0x89, 0xF1})});  // a first frame, and nothing behind it
  for (int i = 0; i < 101; ++i) tick();
  CHECK(tick({frame_of({0x21, 0x89, 0xF1, 0x89, 0xF1, 0x89, 0xF1, 0x89})}).empty());
  CHECK((ask({0x3E, 0x00}) == Bytes{0x7E, 0x00}));
}

TEST(UdsServer, ARequestBeyondTheBufferIsRefusedByFlowControlAndAWrongNumberEndsOne) {
  const auto refused = tick({frame_of({0x10, 0x41, 0x22, 1, 2, 3, 4, 5})});
  LONGS_EQUAL(1, refused.size());
  LONGS_EQUAL(0x32, refused[0].data[0]);
  tick({frame_of({0x10, 0x14, 0x22, 0xF1, 0x89, 0xF1, 0x89, 0xF1})});
  CHECK(tick({frame_of({0x22, 1, 2, 3, 4, 5, 6, 7})}).empty());
  CHECK(tick({frame_of({0x21, 1, 2, 3, 4, 5, 6, 7})}).empty());
}

TEST(UdsServer, FramesOfOthersAreNotLookedAt) {
  CHECK(tick({frame_of({0x02, 0x3E, 0x00}, diagnostic_id(kMasterAddress, kTesterAddress))}).empty());
  CHECK(tick({frame_of({0x02, 0x3E, 0x00}, 0x0B0)}).empty());
}

/// Whatever arrives: bounded frames, no restart but on request, and it answers afterwards.
TEST(UdsServer, DrawnFramesDoNothingWorse) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const std::uint64_t seed = given != nullptr ? std::strtoull(given, nullptr, 10) : 14'229;
  std::printf("VOLTLAP_TEST_SEED=%llu\n", static_cast<unsigned long long>(seed));
  std::mt19937_64 draw(seed);
  view.may_restart = false;
  std::uint64_t sent = 0;
  for (int t = 0; t < 200'000; ++t) {
    std::vector<Frame> rx;
    for (std::uint64_t i = draw() % 4; i > 0; --i) {
      Bytes bytes(draw() % 9);
      for (auto& b : bytes) b = static_cast<std::uint8_t>(draw());
      static const std::uint8_t heads[] = {0x02, 0x03, 0x07, 0x10, 0x21, 0x22, 0x30, 0x31, 0x32};
      static const std::uint8_t services[] = {0x10, 0x11, 0x19, 0x22, 0x3E};
      if (!bytes.empty() && draw() % 2 == 0) bytes[0] = heads[draw() % sizeof heads];
      if (bytes.size() > 1 && draw() % 2 == 0) bytes[1] = services[draw() % sizeof services];
      rx.push_back(frame_of(bytes));
    }
    view.faults_now = static_cast<std::uint32_t>(draw());
    sent += tick(rx).size();
    CHECK(server.restart() == UdsRestart::kNone);
  }
  std::printf("%llu frames answered\n", static_cast<unsigned long long>(sent));
  CHECK(sent > 10'000);
  for (int i = 0; i < 300; ++i) tick();
  CHECK((ask({0x3E, 0x00}) == Bytes{0x7E, 0x00}));
}

TEST(UdsServer, ARequestToStayInTheBootLoaderIsTakenOnceAndChanceIsNone) {
  alignas(8) std::uint32_t memory[2] = {0xDEAD'BEEFU, 0x1234'5678U};
  auto& request = *reinterpret_cast<BootRequest*>(memory);
  CHECK(!request.take());
  request.ask();
  CHECK(request.take());
  CHECK(!request.take());
}
