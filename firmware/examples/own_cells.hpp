// SPDX-License-Identifier: Apache-2.0
// A BMS whose board measures the cells itself gets them as the frames that a monitor on the bus would have sent.
#pragma once
#include "app/bms_node.hpp"
#include "app/cell_monitor.hpp"
#include "port/cells.hpp"

namespace voltlap::examples {

class OwnCells {
 public:
  static constexpr std::size_t kFramesMax = app::CellMonitor::kFramesMax;

  /// `cells` nullptr: monitors on the bus do it.
  OwnCells(port::Cells* cells, const bms::Config& config)
      : cells_(cells), monitor_(config.cells_in_series, config.temperature_sensors) {}

  /// Before a tick: what has been measured. Returns how many frames; `frames` has room for kFramesMax.
  std::size_t take(Instant now, Frame* frames) {
    if (cells_ == nullptr) return 0;
    cells_->step();
    return monitor_.frames(now, *cells_, frames);
  }
  /// After a tick: what is to be bled.
  void bleed(const bms::Output& output) {
    constexpr std::size_t kWords = sizeof output.charge.bled / sizeof output.charge.bled[0];
    if (cells_ != nullptr && output.charge.on) cells_->bleed(output.charge.bled, kWords);
  }

 private:
  port::Cells* cells_;
  app::CellMonitor monitor_;
};

}  // namespace voltlap::examples
