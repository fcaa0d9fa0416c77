// SPDX-License-Identifier: Apache-2.0
// The bench with cells, a charger that gives what it is asked for, and shunts.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "bms/bench.hpp"
#include "bms/charge/charge_config.hpp"

namespace voltlap::bms::test {

inline Config charge_config() {
  Config c = pack_config();
  c.charger_current_max = amps(20);
  return c;
}

class ChargeBench {
 public:
  explicit ChargeBench(const Config& c = charge_config(), double start = 0.5) : bench(c), cells(c.cells_in_series) {
    for (Cell& cell : cells) cell.soc = start;
    bench.sum_follows_cells = false;
    bench.charger_talks = true;
    show();
  }

  struct Cell {
    double soc = 0.5, capacity = 1.0, resistance = 1.0;  ///< shares of the configured ones
    double drift_v = 0.0;                                 ///< of its channel
  };

  Bench bench;
  std::vector<Cell> cells;
  double gives_at_most_a = 1e9, flows_besides_a = 0.0;
  double shunt_a = 0.2, sense_v = 0.1;  ///< and what its current takes from the reading
  std::function<double(double)> ocv = [](double soc) { return 3.0 + 1.2 * soc; };
  double highest_v = 0.0;
  bool bled_with_open_shutdown = false;

  const Output& tick() {
    const bool closed = bench.out.contactors.air_plus && bench.out.contactors.air_minus;
    const double asked = bench.out.charge.asked.raw() * 1e-3;
    current_a = closed ? std::min(asked, gives_at_most_a) + flows_besides_a : 0.0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const double shunt = bench.state.balancing[i] ? shunt_a : 0.0;
      cells[i].soc += (current_a - shunt) * 0.01 / 36'000.0 / cells[i].capacity;
    }
    show();
    bench.tick();
    if (!bench.io.shutdown_closed && bench.state.cells_bled > 0) bled_with_open_shutdown = true;
    return bench.out;
  }
  void run(std::uint32_t ms) {
    for (std::uint32_t t = 0; t < ms; t += 10) tick();
  }
  std::int32_t until(const std::function<bool(const Output&)>& done, std::int32_t most_ms) {
    for (std::int32_t t = 0; t <= most_ms; t += 10) {
      if (done(tick())) return t;
    }
    return -1;
  }
  std::int32_t until_phase(can::ChargePhase phase, std::int32_t most_ms) {
    return until([phase](const Output& o) { return o.charge.phase == phase; }, most_ms);
  }
  /// From power-on until current flows.
  void charge() {
    run(3'000);
    bench.io.charge_switch = true;
    CHECK(until([](const Output& o) { return o.charge.asked >= amps(1); }, 20'000) >= 0);
  }
  [[nodiscard]] can::ChargeReason reason() const { return bench.out.charge.reason; }
  [[nodiscard]] can::ChargePhase phase() const { return bench.out.charge.phase; }

 private:
  void show() {
    double sum = 0.0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const double v = ocv(cells[i].soc) + 0.002 * cells[i].resistance * current_a;
      highest_v = std::max(highest_v, v);
      sum += v;
      const double read = cells[i].drift_v + (bench.state.balancing[i] ? v - sense_v : v);
      bench.cell_100uv[i] = static_cast<std::int32_t>(std::lround(1e4 * read));
    }
    bench.pack.pack_voltage_100uv = static_cast<std::int32_t>(std::lround(1e4 * sum));
    bench.current(amps(-current_a));
  }

  double current_a = 0.0;
};

}  // namespace voltlap::bms::test
