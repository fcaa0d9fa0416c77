// SPDX-License-Identifier: Apache-2.0
// ISO 15765-2:2016, as DIA-001 and DIA-002 need it.
#include "app/iso_tp.hpp"

#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "CppUTest/TestHarness.h"
#include "firmware/app/iso_tp_bench.hpp"

using namespace voltlap;
using namespace voltlap::app::test;
using app::IsoTp;

namespace {

constexpr std::uint8_t kPadding = 0xCC;

}  // namespace

TEST_GROUP(IsoTp) {
  IsoTp link{kToNode, kFromNode};
  Instant now = Instant::from_ms(5'000);

  bool receive(const Bytes& bytes) { return link.receive(now, frame_of(bytes)); }
  [[nodiscard]] Bytes request() const { return Bytes(link.request(), link.request() + link.request_bytes()); }
  /// The frames of the next tick, 10 ms later.
  std::vector<Bytes> tick(std::int32_t ms = 10) {
    now = now + Duration::from_ms(ms);
    TxQueue tx;
    link.tick(now, tx);
    std::vector<Bytes> out;
    for (const Frame& f : tx) {
      UNSIGNED_LONGS_EQUAL(kFromNode, f.id);
      LONGS_EQUAL(8, f.dlc);
      out.emplace_back(f.data, f.data + 8);
    }
    return out;
  }
  void nothing_for(std::int32_t ms) {
    for (std::int32_t t = 0; t < ms; t += 10) CHECK(tick().empty());
  }
  void respond(const Bytes& bytes) { link.respond(bytes.data(), bytes.size()); }
  /// A response of `count` bytes whose first frame is out.
  void begin(std::size_t count) {
    respond(counted(count));
    LONGS_EQUAL(1, tick().size());
  }
};

TEST(IsoTp, SingleFrameOfEveryLengthIsARequest) {
  for (std::size_t count = 1; count <= 7; ++count) {
    Bytes bytes = {static_cast<std::uint8_t>(count)};
    for (std::size_t i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(0x40 + i));
    CHECK(receive(bytes));
    CHECK((request() == Bytes(bytes.begin() + 1, bytes.end())));
    bytes.pop_back();
    CHECK_FALSE(receive(bytes));  // one byte is missing
  }
}

// Nothing, more than a frame holds.
TEST(IsoTp, SingleFrameOfAnImpossibleLengthIsNotLookedAt) {
  CHECK_FALSE(receive({}));
  for (const std::uint8_t count : Bytes{0, 8, 15}) CHECK_FALSE(receive({count, 1, 2, 3, 4, 5, 6, 7}));
  Frame long_code = frame_of({0x08, 1, 2, 3, 4, 5, 6, 7});
  long_code.dlc = 15;  // ISO 11898-1: 9 to 15 are 8 bytes, too
  CHECK_FALSE(link.receive(now, long_code));
  LONGS_EQUAL(0, link.request_bytes());
}

TEST(IsoTp, FramesOfOthersAndOfUnknownKindsAreNotLookedAt) {
  CHECK_FALSE(link.receive(now, frame_of({2, 0x3E, 0}, kFromNode)));
  for (unsigned kind = 4; kind < 16; ++kind) {
    CHECK_FALSE(receive({static_cast<std::uint8_t>(kind << 4 | 2), 0x3E, 0, 0, 0, 0, 0, 0}));
  }
  CHECK(tick().empty());
}

// Block size and separation 0: all at once, as fast as it likes.
TEST(IsoTp, RequestInSeveralFramesIsPutTogetherWhateverItsLength) {
  for (std::size_t count = 8; count <= IsoTp::kRequestMost; ++count) {
    const auto frames = segmented(counted(count));
    CHECK_FALSE(link.receive(now, frames[0]));
    const auto flow = tick();
    LONGS_EQUAL(1, flow.size());
    CHECK((flow[0] == Bytes{0x30, 0, 0, kPadding, kPadding, kPadding, kPadding, kPadding}));
    CHECK(tick().empty());
    for (std::size_t i = 1; i + 1 < frames.size(); ++i) CHECK_FALSE(link.receive(now, frames[i]));
    CHECK(link.receive(now, frames.back()));
    CHECK((request() == counted(count)));
    const std::uint8_t more = static_cast<std::uint8_t>(0x20 | (frames.size() & 0xF));
    CHECK_FALSE(receive({more, 1, 2, 3, 4, 5, 6, 7}));  // it is whole once
    CHECK_FALSE(link.receive(now, frames.back()));
  }
}

// What fits a single frame, and a first frame that is not full
TEST(IsoTp, FirstFrameOfAnImpossibleLengthIsNotLookedAt) {
  for (const std::uint8_t count : Bytes{0, 1, 6, 7}) CHECK_FALSE(receive({0x10, count, 1, 2, 3, 4, 5, 6}));
  CHECK_FALSE(receive({0x10, 20, 1, 2, 3, 4, 5}));
  CHECK(tick().empty());
  CHECK_FALSE(receive({0x21, 7, 8, 9, 10, 11, 12, 13}));
  CHECK_FALSE(receive({0x10, 8, 1, 2, 3, 4, 5, 6}));
  LONGS_EQUAL(1, tick().size());
}

// Refused by overflow, and what comes all the same is not taken
TEST(IsoTp, RequestBeyondTheBufferIsRefused) {
  for (const std::size_t count : {std::size_t{65}, std::size_t{0x110}, std::size_t{0xFFF}}) {
    const auto under_way = segmented(counted(20));
    link.receive(now, under_way[0]);
    CHECK_FALSE(receive({static_cast<std::uint8_t>(0x10 | count >> 8), static_cast<std::uint8_t>(count), 1, 2, 3, 4, 5,
                         6}));
    const auto flow = tick();
    LONGS_EQUAL(1, flow.size());
    CHECK((flow[0] == Bytes{0x32, 0, 0, kPadding, kPadding, kPadding, kPadding, kPadding}));
    for (std::size_t i = 1; i < under_way.size(); ++i) CHECK_FALSE(link.receive(now, under_way[i]));
  }
}

// 9.6.4.4: the message is given up
TEST(IsoTp, WrongNumberOrShortFrameEndsARequest) {
  const auto frames = segmented(counted(20));
  for (const int what : {0, 1, 2, 3}) {
    link.receive(now, frames[0]);
    if (what == 0) CHECK_FALSE(link.receive(now, frames[2]));  // one is missing
    if (what == 1) {
      CHECK_FALSE(link.receive(now, frames[1]));
      CHECK_FALSE(link.receive(now, frames[1]));  // twice
    }
    if (what == 2) {
      Frame shorter = frames[1];
      shorter.dlc = 7;
      CHECK_FALSE(link.receive(now, shorter));
    }
    if (what == 3) CHECK(receive({0x02, 0x3E, 0x00}));  // another request
    for (std::size_t i = 1; i < frames.size(); ++i) CHECK_FALSE(link.receive(now, frames[i]));
  }
}

TEST(IsoTp, LastFrameIsAsLongAsItsBytesOrPadded) {
  auto frames = segmented(counted(16));  // 6 + 7 + 3
  LONGS_EQUAL(4, frames.back().dlc);
  for (const std::uint8_t dlc : Bytes{4, 5, 8}) {
    frames.back().dlc = dlc;
    CHECK_FALSE(link.receive(now, frames[0]));
    CHECK_FALSE(link.receive(now, frames[1]));
    CHECK(link.receive(now, frames[2]));
  }
  frames.back().dlc = 3;
  CHECK_FALSE(link.receive(now, frames[0]));
  CHECK_FALSE(link.receive(now, frames[1]));
  CHECK_FALSE(link.receive(now, frames[2]));
}

// N_Cr: from the last frame of it
TEST(IsoTp, RequestThatFallsSilentForASecondIsGivenUp) {
  const auto frames = segmented(counted(20));
  for (const bool late : {false, true}) {
    link.receive(now, frames[0]);
    tick(990);
    CHECK_FALSE(link.receive(now, frames[1]));
    tick(late ? 1'000 : 999);
    CHECK_EQUAL(!late, link.receive(now, frames[2]));
    tick(late ? 0 : 10'000);
  }
}

TEST(IsoTp, ShortResponseIsASingleFrame) {
  for (std::size_t count = 1; count <= 7; ++count) {
    respond(counted(count));
    CHECK(link.sending());
    const auto out = tick();
    LONGS_EQUAL(1, out.size());
    Bytes expected = {static_cast<std::uint8_t>(count)};
    for (std::size_t i = 1; i <= 7; ++i) expected.push_back(i <= count ? static_cast<std::uint8_t>(i) : kPadding);
    CHECK((out[0] == expected));
    CHECK_FALSE(link.sending());
    CHECK(tick().empty());
  }
}

// Numbered 1 to 15 and 0 again, one a tick, the rest padded
TEST(IsoTp, LongResponseIsNumberedAndPaddedWhateverItsLength) {
  for (std::size_t count = 8; count <= IsoTp::kResponseMost; ++count) {
    const Bytes message = counted(count);
    respond(message);
    auto out = tick();
    LONGS_EQUAL(1, out.size());
    LONGS_EQUAL(0x10, out[0][0]);
    LONGS_EQUAL(count, out[0][1]);
    Bytes got(out[0].begin() + 2, out[0].end());
    CHECK_FALSE(receive({0x30, 0, 0}));
    std::uint8_t number = 1;
    while (link.sending()) {
      out = tick();
      LONGS_EQUAL(1, out.size());
      LONGS_EQUAL(0x20 | (number++ & 0xF), out[0][0]);
      got.insert(got.end(), out[0].begin() + 1, out[0].end());
    }
    CHECK(got.size() >= count && got.size() < count + 7);
    Bytes expected = message;
    expected.resize(got.size(), kPadding);
    CHECK((got == expected));
    CHECK(tick().empty());
  }
}

// STmin: 0 to 127 ms, 100 to 900 us, and the longest for what is reserved
TEST(IsoTp, FramesKeepTheSeparationThatIsAsked) {
  const struct {
    std::uint8_t asked;
    std::int32_t ms;
  } rows[] = {{0, 0},     {1, 1},      {50, 50},    {0x7F, 127}, {0x80, 127}, {0xF0, 127},
              {0xF1, 1},  {0xF5, 1},   {0xF9, 1},   {0xFA, 127}, {0xFF, 127}};
  for (const auto& row : rows) {
    begin(27);
    tick(200);
    receive({0x30, 0, row.asked});
    LONGS_EQUAL(1, tick(1).size());  // the first one at once
    for (int k = 0; k < 2; ++k) {
      for (std::int32_t ms = 1; ms < row.ms; ++ms) CHECK(tick(1).empty());
      if (row.ms > 0) CHECK(tick(0).empty());
      LONGS_EQUAL(1, tick(row.ms == 0 ? 0 : 1).size());
    }
    CHECK_FALSE(link.sending());
  }
}

TEST(IsoTp, BlockEndsWithItsLastFrameAndTheNextIsAsked) {
  for (const std::uint8_t size : Bytes{1, 2, 3}) {
    begin(6 + 6 * 7);
    for (int block = 0; block < 6 / size; ++block) {
      CHECK(link.sending());
      nothing_for(100);
      receive({0x30, size, 0});
      for (int k = 0; k < size; ++k) LONGS_EQUAL(1, tick().size());
    }
    CHECK_FALSE(link.sending());
  }
}

// The size of a block is of its flow control alone
TEST(IsoTp, BlockWithoutAnEndAfterOneWithOneGoesToTheEnd) {
  begin(6 + 6 * 7);
  receive({0x30, 2, 0});
  for (int k = 0; k < 2; ++k) LONGS_EQUAL(1, tick().size());
  nothing_for(50);
  receive({0x30, 0, 0});
  for (int k = 0; k < 4; ++k) LONGS_EQUAL(1, tick().size());
  CHECK_FALSE(link.sending());
}

// N_Bs: a second from the frame that waits for it, and from each wait
TEST(IsoTp, TesterThatSendsNoFlowControlForASecondIsGivenUp) {
  for (const std::int32_t ms : {999, 1'000}) {
    begin(20);
    CHECK(tick(ms).empty());
    CHECK_EQUAL(ms < 1'000, link.sending());
    receive({0x30, 1, 0});
    LONGS_EQUAL(ms < 1'000 ? 1 : 0, tick().size());
    CHECK(tick(ms).empty());
    CHECK_EQUAL(ms < 1'000, link.sending());
  }
}

// N_WFTmax
TEST(IsoTp, TesterMayAskToWaitTenTimesInARow) {
  for (const int waits : {10, 11}) {
    begin(20);
    for (int k = 0; k < waits; ++k) {
      CHECK(tick(900).empty());
      receive({0x31, 0, 0});
    }
    CHECK_EQUAL(waits == 10, link.sending());
    receive({0x30, 1, 0});
    LONGS_EQUAL(waits == 10 ? 1 : 0, tick().size());
    for (int k = 0; k < 10; ++k) {  // of the next block
      CHECK(tick(900).empty());
      receive({0x31, 0, 0});
    }
    CHECK_EQUAL(waits == 10, link.sending());
  }
  begin(20);  // one that was given up is not held against the next
  receive({0x31, 0, 0});
  CHECK(link.sending());
}

// Overflow, and what is reserved
TEST(IsoTp, FlowControlThatRefusesEndsTheResponse) {
  for (std::uint8_t status = 2; status < 16; ++status) {
    begin(20);
    receive({static_cast<std::uint8_t>(0x30 | status), 0, 0});
    CHECK_FALSE(link.sending());
    receive({0x30, 0, 0});
    nothing_for(50);
  }
}

TEST(IsoTp, FlowControlThatIsCutShortIsNotLookedAt) {
  begin(20);
  for (const Bytes& bytes : {Bytes{0x30}, Bytes{0x30, 0}, Bytes{0x32, 0}}) {
    CHECK_FALSE(receive(bytes));
    CHECK(tick().empty());
    CHECK(link.sending());
  }
}

// Unexpected flow control is ignored; before the first frame is out nobody can have seen it.
TEST(IsoTp, FlowControlThatNobodyWaitsForIsNotLookedAt) {
  for (const std::uint8_t status : Bytes{0x30, 0x31, 0x32}) {
    receive({status, 0, 0});  // nothing is sent at all
    respond(counted(20));
    receive({status, 0, 0});  // before the first frame
    LONGS_EQUAL(1, tick().size());
    CHECK(link.sending());
    nothing_for(50);
    receive({0x30, 0, 20});
    LONGS_EQUAL(1, tick().size());
    receive({status, 0, 0});  // within the block
    CHECK(tick().empty());
    LONGS_EQUAL(1, tick().size());
    CHECK_FALSE(link.sending());
  }
}

TEST(IsoTp, FullQueueDelaysAndLosesNothing) {
  const auto full_tick = [this] {
    TxQueue tx;
    while (tx.push(Frame{})) {}
    now = now + Duration::from_ms(10);
    link.tick(now, tx);
    LONGS_EQUAL(TxQueue::kCapacity, tx.size());
  };
  receive({0x10, 20, 1, 2, 3, 4, 5, 6});
  respond(counted(16));
  for (int k = 0; k < 150; ++k) full_tick();
  auto out = tick();
  LONGS_EQUAL(2, out.size());
  LONGS_EQUAL(0x30, out[0][0]);
  LONGS_EQUAL(0x10, out[1][0]);
  CHECK(tick(990).empty());  // the time for flow control begins with the frame that went out
  CHECK(link.sending());
  receive({0x30, 2, 0});
  for (int k = 0; k < 3; ++k) full_tick();  // what has not gone out is none of the block
  out = tick();
  LONGS_EQUAL(1, out.size());
  LONGS_EQUAL(0x21, out[0][0]);
  full_tick();
  out = tick();
  LONGS_EQUAL(1, out.size());
  CHECK((out[0] == Bytes{0x22, 14, 15, 16, kPadding, kPadding, kPadding, kPadding}));
}

/// Two ends, every length each way, with separation and blocks as drawn: what arrives is what was sent.
TEST(IsoTp, DrawnResponsesArriveWhole) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const unsigned seed = given == nullptr ? std::random_device{}() : static_cast<unsigned>(std::stoul(given));
  std::mt19937 draw(seed);
  const std::string what = "VOLTLAP_TEST_SEED=" + std::to_string(seed);
  for (int k = 0; k < 300; ++k) {
    Bytes message(1 + draw() % IsoTp::kResponseMost);
    for (std::uint8_t& byte : message) byte = static_cast<std::uint8_t>(draw());
    const auto size = static_cast<std::uint8_t>(draw() % 4), separation = static_cast<std::uint8_t>(draw() % 30);
    respond(message);
    Bytes got;
    int in_block = 0;
    for (int t = 0; t < 400 && got.size() < message.size(); ++t) {
      for (const Bytes& f : tick()) {
        const unsigned kind = f[0] >> 4;
        got.insert(got.end(), f.begin() + (kind == 1 ? 2 : 1), f.end());
        if (kind == 1 || (size != 0 && ++in_block % size == 0)) receive({0x30, size, separation});
        if (kind == 1) in_block = 0;
      }
    }
    got.resize(got.size() < message.size() ? got.size() : message.size());
    CHECK_TEXT(got == message, what.c_str());
    CHECK_FALSE_TEXT(link.sending(), what.c_str());
  }
}
