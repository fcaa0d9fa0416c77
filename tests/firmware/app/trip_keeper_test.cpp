// SPDX-License-Identifier: Apache-2.0
#include "app/trip_keeper.hpp"

#include <vector>

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
        if (!keeper.due(node, slot, bytes)) continue;
        kept[slot] = bytes;
        written_to.push_back(slot);
      }
    }
    bms::TripSlot (&kept)[bms::kTripSlots];
    BmsNode node;
    TripKeeper keeper;
    TxQueue tx;
    std::vector<std::size_t> written_to;  ///< the slots, in turn
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

// BMS-025: a writing that is cut off leaves the one before it, so they go to the two slots in turns; only what has
// changed is written.
TEST(TripKeeper, EachChangeIsWrittenOnceIntoTheOlderSlot) {
  for (const std::size_t newest : {std::size_t{0}, std::size_t{1}}) {
    memory[newest] = bms::to_slot({0, 8});
    memory[1 - newest] = bms::to_slot({0, 7});
    Bench bench;
    Powered node(memory, bench);
    node.run(bench, 500);
    CHECK(node.written_to.empty());
    bench.cell_100uv[7] = 23'000;
    node.run(bench, 600);
    CHECK((node.written_to == std::vector<std::size_t>{1 - newest}));
    bench.cell_100uv[7] = 44'000;  // one more
    node.run(bench, 600);
    CHECK((node.written_to == std::vector<std::size_t>{1 - newest, newest}));
    const bms::TripHistory history = bms::read_slots(memory);
    LONGS_EQUAL(10, history.newest.writing);
    CHECK(history.newest.latched == node.node.state().faults.latched);
    LONGS_EQUAL(1 - newest, history.oldest_slot);
  }
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
