// SPDX-License-Identifier: Apache-2.0
#include "app/soc_keeper.hpp"

#include <vector>

#include "bms/bench.hpp"
#include "bms/estimate/filter_bench.hpp"

using namespace voltlap;
using namespace voltlap::app;
using bms::test::Bench;
using bms::test::TrueCell;

TEST_GROUP(SocKeeper) {
  bms::SocSlot memory[bms::kSocSlots] = {};
  bms::Config config = bms::test::filtered_config();
  TrueCell cell;
  int written = 0;

  /// A node of its own, fed by the bench's frames of a pack whose cells are all `cell`.
  struct Powered {
    explicit Powered(bms::SocSlot (&slots)[bms::kSocSlots], const bms::Config& c) : bench(c), node(c), kept(slots) {
      keeper.restore(kept, node);
    }
    void run(TrueCell& cell, double amperes, double seconds, int& written) {
      for (double t = 0.0; t < seconds; t += 0.01) {
        cell.advance(amperes, 0.01);
        bench.cells(static_cast<std::int32_t>(1e4 * cell.voltage(bench.config)));
        bench.current(bms::test::amps(amperes));
        const Instant now = bench.now();
        bench.tick();
        tx.clear();
        node.tick(now, bench.sent(), tx);
        std::size_t slot = 0;
        bms::SocSlot bytes;
        if (!keeper.due(node, slot, bytes)) continue;
        kept[slot] = bytes;
        written_to.push_back(slot);
        ++written;
      }
    }
    double soc() const { return 1e-6 * node.state().soc.value.raw(); }
    Bench bench;
    BmsNode node;
    bms::SocSlot (&kept)[bms::kSocSlots];
    SocKeeper keeper;
    TxQueue tx;
    std::vector<std::size_t> written_to;  ///< the slots, in turn
  };
};

// BMS-082, BMS-083
TEST(SocKeeper, ARestartInMidLapGoesOnWhereTheChargeWas) {
  for (const bms::SocMethod method : {bms::SocMethod::kEkf, bms::SocMethod::kCoulomb}) {
    config.soc_method = method;
    cell = TrueCell{};
    for (bms::SocSlot& slot : memory) slot = bms::SocSlot{};
    double before = 0.0;
    {
      Powered first(memory, config);
      first.run(cell, 0.0, 1.0, written);
      first.run(cell, 80.0, 120.0, written);
      before = first.soc();
    }
    DOUBLES_EQUAL(cell.soc, before, 0.01);
    Powered second(memory, config);
    second.run(cell, 80.0, 1.0, written);  // never at rest
    CHECK(second.node.state().soc.valid);
    std::printf("BMS-082: SOC %.2f %% before the restart, %.2f %% after it\n", 100.0 * before, 100.0 * second.soc());
    DOUBLES_EQUAL(before, second.soc(), 0.02);
  }
}

// BMS-083
TEST(SocKeeper, AWritingEveryHalfPoint) {
  Powered node(memory, config);
  node.run(cell, 0.0, 1.0, written);
  LONGS_EQUAL(1, written);
  node.run(cell, 90.0, 40.0, written);  // ten points
  CHECK(written >= 19 && written <= 21);
}

// BMS-083
TEST(SocKeeper, ChargingIsWrittenAsDischargingIs) {
  cell.soc = 0.5;
  Powered node(memory, config);
  node.run(cell, 0.0, 1.0, written);
  node.run(cell, -90.0, 40.0, written);
  CHECK(written >= 19 && written <= 21);
}

// BMS-083
TEST(SocKeeper, AnEmptyPackIsWrittenToo) {
  cell.soc = 0.001;
  Powered node(memory, config);
  node.run(cell, 0.0, 2.0, written);
  CHECK(node.soc() < 0.005);
  LONGS_EQUAL(1, written);
}

// BMS-083: a writing that is cut off leaves the one before it, so they go to the two slots in turns.
TEST(SocKeeper, TheSlotsAreWrittenInTurnsAndTheNewestIsKnownByItsNumber) {
  std::size_t newest_slot = 0;
  std::uint16_t writings = 0;
  for (int powered = 0; powered < 3; ++powered) {
    Powered node(memory, config);
    node.run(cell, powered == 0 ? 0.0 : 60.0, 1.0, written);
    node.run(cell, 90.0, powered == 0 ? 5.0 : 7.0, written);
    CHECK(node.written_to.size() >= 3);
    if (powered > 0) LONGS_EQUAL(1 - newest_slot, node.written_to[0]);
    for (std::size_t i = 1; i < node.written_to.size(); ++i) {
      LONGS_EQUAL(1 - node.written_to[i - 1], node.written_to[i]);
    }
    newest_slot = node.written_to.back();
    writings = static_cast<std::uint16_t>(writings + node.written_to.size());
    bms::SocRecord newest;
    std::size_t oldest_slot = 0;
    bms::read_slots(memory, newest, oldest_slot);
    LONGS_EQUAL(1 - newest_slot, oldest_slot);
    LONGS_EQUAL(writings, newest.writing);
  }
}

// BMS-048, BMS-083: the distance goes on over a loss of the supply.
TEST(SocKeeper, TheWayThatWasDrivenIsKeptToo) {
  config.energy_to_go_m = 10'000;
  config.um_per_motor_turn = 400'000;
  std::uint16_t kept = 0;
  for (int powered = 0; powered < 3; ++powered) {
    Powered node(memory, config);
    node.run(cell, 0.0, powered == 0 ? 1.0 : 0.1, written);
    LONGS_EQUAL(kept, node.node.state().energy_to_go.pieces);
    node.bench.inverter.motor_speed_rpm = 6'000;  // 40 m/s: a piece every 2.5 s, a writing every 2 s
    node.run(cell, 90.0, 20.0, written);
    bms::SocRecord newest;
    std::size_t oldest_slot = 0;
    bms::read_slots(memory, newest, oldest_slot);
    CHECK(newest.pieces >= kept + 6 && newest.pieces <= kept + 8);
    kept = newest.pieces;
  }
}

// BMS-083
TEST(SocKeeper, ADamagedMemoryIsNone) {
  for (bms::SocSlot& slot : memory) {
    bms::to_slot(bms::SocRecord{}, slot);
    slot.bytes[9] ^= 1U;
  }
  Powered node(memory, config);
  node.run(cell, 20.0, 1.0, written);
  CHECK_FALSE(node.node.state().soc.valid);
  node.run(cell, 0.0, 1.0, written);
  CHECK(node.node.state().soc.valid);
}
