// SPDX-License-Identifier: Apache-2.0
// BMS and master controller on a board each, emulated or processes, with supplies that can be lost: what a board keeps
// over that is what its own memory keeps.
#pragma once
#include "apps/ecu_board.hpp"
#include "apps/supply.hpp"
#include "io/bus/harness_bus.hpp"
#include "race/report/run_result.hpp"

namespace voltlap::plant {

class SuppliedBoards final : public SuppliedEcus {
 public:
  /// Starts both. Throws InputError that says what to install or to build, and for an image with a configuration of its
  /// own: a harness drives many cars.
  SuppliedBoards(const EcuOptions& options, const bms::Config& bms, const master::Config& master);

  void bms(Instant now, FrameView rx, TxQueue& tx) override { step(bms_, now, rx, tx); }
  void master(Instant now, FrameView rx, TxQueue& tx) override { step(master_, now, rx, tx); }
  void lose(Sender node) override;
  void reset(Sender node, Instant now, Duration off) override;

  /// The run is over, for those that still live.
  void end();
  [[nodiscard]] EcuResult result() const;

 private:
  struct Unit {
    EcuBoard board;
    Supply supply{.dead = false, .fresh = false, .back = {}};
  };
  static void step(Unit& unit, Instant now, FrameView rx, TxQueue& tx);
  Unit& unit_of(Sender node) { return node == Sender::kBms ? bms_ : master_; }

  Unit bms_, master_;
};

}  // namespace voltlap::plant
