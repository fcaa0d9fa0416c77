// SPDX-License-Identifier: Apache-2.0
#include "app/trip_keeper.hpp"

#include "bms/bench.hpp"

using namespace voltlap;
using namespace voltlap::app;
using bms::test::Bench;
using can::BmsFault;

TEST_GROUP(TripKeeper) {
  bms::TripSlot memory[bms::kTripSlots] = {};
  /// A node of its own, fed by the bench's frames.
  struct Powered {
    explicit Powered(bms::TripSlot (&slots)[bms::kTripSlots], Bench& bench) : kept(slots), node(bench.config) {
      keeper.restore(kept, node);
    }
    void run(Bench& bench, std::uint32_t ms) {
      for (std::uint32_t t = 0; t < ms; t += 10) {
        const Instant now = bench.now();
        bench.tick();
        tx.clear();
        node.tick(now, bench.sent(), tx);
        std::size_t slot = 0;
        bms::TripSlot bytes;
        if (keeper.due(node, slot, bytes)) kept[slot] = bytes;
      }
    }
    bms::TripSlot (&kept)[bms::kTripSlots];
    BmsNode node;
    TripKeeper keeper;
    TxQueue tx;
  };
};

// BMS-025
TEST(TripKeeper, ATripOutlivesThePowerCycleAndIsLeftByTheReset) {
  Bench bench;
  {
    Powered first(memory, bench);
    first.run(bench, 500);
    bench.cell_100uv[7] = 23'000;
    first.run(bench, 600);
    CHECK(bms::test::has(first.node.output(), BmsFault::kCellVoltageLow));
  }
  Bench again;  // its contactors are those of the second node: open
  again.aux_follow_command = again.link_follows = false;
  Powered second(memory, again);
  second.run(again, 1000);
  CHECK(bms::test::has(second.node.output(), BmsFault::kCellVoltageLow));
  CHECK(second.node.output().state != can::BmsState::kIdle);
  again.request(true);
  second.run(again, 3000);
  CHECK(bms::test::all_open(second.node.output()));
  again.request(false);
  again.master.reset_request = true;
  second.run(again, 200);
  LONGS_EQUAL(0, second.node.output().faults);
  CHECK(second.node.output().state == can::BmsState::kIdle);
  Bench third;
  Powered reset(memory, third);
  reset.run(third, 1000);
  LONGS_EQUAL(0, reset.node.output().faults);
}

// BMS-025
TEST(TripKeeper, ADamagedMemoryAsksForTheReset) {
  memory[0] = memory[1] = bms::to_slot({1, 1});
  memory[0].bytes[2] ^= 1U;
  memory[1].bytes[2] ^= 1U;
  Bench bench;
  Powered node(memory, bench);
  node.run(bench, 1000);
  CHECK(bms::test::has(node.node.output(), BmsFault::kConfigInvalid));
  bench.request(true);
  node.run(bench, 2000);
  CHECK(bms::test::all_open(node.node.output()));
}
