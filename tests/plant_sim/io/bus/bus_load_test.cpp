// SPDX-License-Identifier: Apache-2.0
#include "io/bus/bus_load.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

constexpr std::uint32_t kTick_ms = 10;
constexpr std::uint32_t kBitRate = 500'000;
constexpr double kTickBits = 5'000.0;

// No data and identifier 0: 53 bits, counted by hand in frame_bits_test.cpp.
Frame zeros() { return {}; }
constexpr double kZeroBits = 53.0;

Frame frame(std::uint32_t id, std::uint8_t byte) {
  Frame f;
  f.id = id;
  f.dlc = 8;
  for (std::uint8_t& b : f.data) b = byte;
  return f;
}

}  // namespace

TEST_GROUP(BusLoad) {
  BusLoad load{kTick_ms, kBitRate};
  void send(std::uint32_t tick, const Frame& f, int times = 1) {
    for (int i = 0; i < times; ++i) load.on_frame(tick, Sender::kPlant, f);
  }
};

TEST(BusLoad, NothingSentIsNoLoad) {
  const BusLoadResult r = load.result();
  LONGS_EQUAL(0, r.rows.size());
  DOUBLES_EQUAL(0.0, r.total_pct, 0.0);
  DOUBLES_EQUAL(0.0, r.peak_100ms_pct, 0.0);
}

TEST(BusLoad, TotalIsTheBitsSentOverTheBitsThatTheTimeHasRoomFor) {
  for (std::uint32_t tick = 0; tick < 200; ++tick) send(tick, zeros());
  const BusLoadResult r = load.result();
  DOUBLES_EQUAL(2.0, r.time_s, 1e-12);
  DOUBLES_EQUAL(100.0 * kZeroBits / kTickBits, r.total_pct, 1e-12);
  DOUBLES_EQUAL(r.total_pct, r.peak_100ms_pct, 1e-12);
  DOUBLES_EQUAL(100.0, r.frames_per_s(r.rows[0]), 1e-9);
}

TEST(BusLoad, RowsAreByIdentifierAndAddUpToTheTotal) {
  send(0, frame(0x200, 0x12), 2);
  send(1, frame(0x036, 0xFF));
  send(2, frame(0x80000036, 0xFF));
  send(3, frame(0x200, 0x00));
  const BusLoadResult r = load.result();
  LONGS_EQUAL(3, r.rows.size());
  LONGS_EQUAL(0x036, r.rows[0].id);
  LONGS_EQUAL(0x200, r.rows[1].id);
  LONGS_EQUAL(0x80000036, r.rows[2].id);
  LONGS_EQUAL(3, r.rows[1].frames);
  LONGS_EQUAL(2 * frame_bits(frame(0x200, 0x12)) + frame_bits(frame(0x200, 0x00)), r.rows[1].bits);
  LONGS_EQUAL(frame_bits(frame(0x200, 0x00)), r.rows[1].bits_worst);
  double sum = 0.0, shares = 0.0;
  for (const BusLoadRow& row : r.rows) {
    sum += r.load_pct(row);
    shares += r.share_pct(row);
  }
  DOUBLES_EQUAL(r.total_pct, sum, 1e-9);
  DOUBLES_EQUAL(100.0, shares, 1e-9);
}

TEST(BusLoad, PeakIsTheFullestTenTicksWhereverTheyBegin) {
  for (std::uint32_t tick = 0; tick < 300; ++tick) send(tick, zeros(), tick >= 137 && tick < 147 ? 5 : 1);
  DOUBLES_EQUAL(5.0 * 100.0 * kZeroBits / kTickBits, load.result().peak_100ms_pct, 1e-12);
}

TEST(BusLoad, BurstShorterThanTheWindowIsSpreadOverIt) {
  send(0, zeros());
  send(50, zeros(), 10);
  send(99, zeros());
  DOUBLES_EQUAL(10.0 * 100.0 * kZeroBits / (10.0 * kTickBits), load.result().peak_100ms_pct, 1e-12);
}

TEST(BusLoad, SilenceEmptiesTheWindowAndCountsAsTime) {
  send(0, zeros(), 3);
  send(9, zeros(), 3);   // still within 100 ms of tick 0
  send(10, zeros(), 4);  // tick 0 has left
  DOUBLES_EQUAL(7.0 * 100.0 * kZeroBits / (10.0 * kTickBits), load.result().peak_100ms_pct, 1e-12);
  send(100'000, zeros(), 6);
  DOUBLES_EQUAL(7.0 * 100.0 * kZeroBits / (10.0 * kTickBits), load.result().peak_100ms_pct, 1e-12);
  DOUBLES_EQUAL(1000.01, load.result().time_s, 1e-9);
}

TEST(BusLoad, PeakOfTheLastWindowCountsToo) {
  for (std::uint32_t tick = 0; tick < 100; ++tick) send(tick, zeros(), tick == 99 ? 50 : 1);
  DOUBLES_EQUAL(59.0 * 100.0 * kZeroBits / (10.0 * kTickBits), load.result().peak_100ms_pct, 1e-12);
}
