// SPDX-License-Identifier: Apache-2.0
#include "app/soc_keeper.hpp"

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
        ++written;
      }
    }
    double soc() const { return 1e-6 * node.state().soc.value.raw(); }
    Bench bench;
    BmsNode node;
    bms::SocSlot (&kept)[bms::kSocSlots];
    SocKeeper keeper;
    TxQueue tx;
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
