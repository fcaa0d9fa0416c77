// SPDX-License-Identifier: Apache-2.0
// On the real vcan0.
#include "port/host/socket_can.hpp"

#include <cstring>
#include <string>

#include "port/host/bus_error.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::port;

namespace {

constexpr std::uint32_t kErrorFrame = 0x20000000, kBusOff = 0x40;

Frame frame(std::uint32_t id, std::uint8_t dlc = 8, std::uint8_t first = 0) { return {id, dlc, {first}}; }

std::string setup_error(const std::string& interface) {
  try {
    SocketCan socket(interface, {});
  } catch (const BusSetupError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_GROUP(SocketCan) {
  SocketCan sender{"vcan0", {}};
  std::vector<Arrival> arrivals;

  void send(const Frame& f) { sender.send(&f, 1); }
  const std::vector<Arrival>& drained(SocketCan & socket) {
    arrivals.clear();
    socket.drain(arrivals);
    return arrivals;
  }
};

TEST(SocketCan, FramesArriveWholeAndInOrder) {
  SocketCan listener("vcan0", {.filters = {kEveryFrame}});
  send(frame(0x123, 8, 1));
  send(frame(0x0A0, 3, 2));
  send(frame(0x18FF1234U | Frame::kExtendedFlag, 0));
  const auto& got = drained(listener);
  LONGS_EQUAL(3, got.size());
  LONGS_EQUAL(0x123, got[0].frame.id);
  LONGS_EQUAL(1, got[0].frame.data[0]);
  LONGS_EQUAL(3, got[1].frame.dlc);
  CHECK_EQUAL(0x18FF1234U | Frame::kExtendedFlag, got[2].frame.id);
  LONGS_EQUAL(0, got[2].frame.dlc);
  CHECK(drained(listener).empty());
}

TEST(SocketCan, OnlyWhatPassesTheFilterWakesANode) {
  SocketCan listener("vcan0", {.filters = {only(0x123), only(0x200)}});
  for (const std::uint32_t id : {0x122U, 0x123U, 0x323U, 0x123U | Frame::kExtendedFlag, 0x200U}) send(frame(id));
  const auto& got = drained(listener);
  LONGS_EQUAL(2, got.size());
  LONGS_EQUAL(0x123, got[0].frame.id);
  LONGS_EQUAL(0x200, got[1].frame.id);
  listener.filter({only(0x300)});
  send(frame(0x123));
  send(frame(0x300));
  LONGS_EQUAL(1, drained(listener).size());
}

TEST(SocketCan, WithoutFiltersNothingIsReceived) {
  SocketCan listener("vcan0", {});
  send(frame(0x123));
  CHECK(drained(listener).empty());
  CHECK_FALSE(listener.wait().has_value());
}

TEST(SocketCan, OwnFramesComeBackMarkedWhenAskedFor) {
  SocketCan both("vcan0", {.filters = {kEveryFrame}, .own_frames = true});
  SocketCan others("vcan0", {.filters = {kEveryFrame}});
  const Frame f = frame(0x111);
  both.send(&f, 1);
  others.send(&f, 1);
  const auto got = drained(both);
  LONGS_EQUAL(2, got.size());
  CHECK(got[0].own && !got[1].own);
  LONGS_EQUAL(1, drained(others).size());
}

TEST(SocketCan, MoreFramesThanABatchHoldsAreReadInOrder) {
  SocketCan listener("vcan0", {.filters = {kEveryFrame}});
  std::vector<Frame> many;
  for (unsigned i = 0; i < 1000; ++i) many.push_back(frame(i & 0x7FF, 8, static_cast<std::uint8_t>(i)));
  sender.send(many.data(), many.size());
  const auto& got = drained(listener);
  LONGS_EQUAL(1000, got.size());
  for (unsigned i = 0; i < 1000; ++i) LONGS_EQUAL(i & 0x7FF, got[i].frame.id);
  LONGS_EQUAL(0, listener.counters().dropped);
}

TEST(SocketCan, ThroughTheSeamANodeTakesAtMostItsCapacity) {
  SocketCan listener("vcan0", {.filters = {kEveryFrame}});
  Can& seam = listener;
  TxQueue queue;
  for (std::uint32_t i = 0; i < 5; ++i) CHECK(queue.push(frame(i)));
  CHECK(static_cast<Can&>(sender).send(queue));
  Frame inbox[3];
  LONGS_EQUAL(3, seam.receive(inbox, 3));
  LONGS_EQUAL(2, inbox[2].id);
  LONGS_EQUAL(2, seam.receive(inbox, 3));
  LONGS_EQUAL(4, inbox[1].id);
  LONGS_EQUAL(0, seam.receive(inbox, 3));
}

TEST(SocketCan, FramesThatNobodyReadInTimeAreCounted) {
  SocketCan listener("vcan0", {.filters = {only(0x123)}});
  const std::vector<Frame> flood(1000, frame(0x123));
  for (int i = 0; i < 60; ++i) sender.send(flood.data(), flood.size());
  const std::size_t kept = drained(listener).size();
  CHECK(kept < 60'000);
  send(frame(0x123));
  LONGS_EQUAL(1, drained(listener).size());
  LONGS_EQUAL(60'000 - kept, listener.counters().dropped);
}

TEST(SocketCan, ErrorFramesAreCountedAndNoFrames) {
  SocketCan listener("vcan0", {.filters = {kEveryFrame}, .error_frames = true});
  SocketCan deaf("vcan0", {.filters = {kEveryFrame}});
  send(frame(kErrorFrame | 0x4));
  send(frame(0x10));
  LONGS_EQUAL(1, drained(listener).size());
  LONGS_EQUAL(1, listener.counters().error_frames);
  LONGS_EQUAL(1, drained(deaf).size());
  LONGS_EQUAL(0, deaf.counters().error_frames);
}

TEST(SocketCan, BusOffIsTheEndOfTheBus) {
  SocketCan listener("vcan0", {.filters = {kEveryFrame}, .error_frames = true});
  send(frame(kErrorFrame | kBusOff));
  std::string text;
  try {
    drained(listener);
  } catch (const BusDownError& error) {
    text = error.what();
  }
  STRCMP_CONTAINS("bus-off", text.c_str());
}

TEST(SocketCan, TimeOfArrivalIsTheWallsWhenAskedFor) {
  SocketCan listener("vcan0", {.filters = {kEveryFrame}, .time_stamps = true});
  send(frame(0x10));
  send(frame(0x11));
  const auto& got = drained(listener);
  LONGS_EQUAL(2, got.size());
  CHECK(got[0].time_us > 1'600'000'000'000'000 && got[1].time_us >= got[0].time_us);
}

TEST(SocketCan, InterfaceThatCannotBeUsedIsNamedWithTheWayOut) {
  STRCMP_CONTAINS("ip link add dev vcan9 type vcan", setup_error("vcan9").c_str());
  STRCMP_CONTAINS("is no CAN interface", setup_error("lo").c_str());
  STRCMP_CONTAINS("1 to 15 characters", setup_error("").c_str());
  STRCMP_CONTAINS("1 to 15 characters", setup_error("sixteen-letters-").c_str());
  STRCMP_EQUAL("", setup_error("vcan0").c_str());
}
