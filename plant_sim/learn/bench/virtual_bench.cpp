// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/virtual_bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "car/battery/pack.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"
#include "learn/bench/relaxation.hpp"
#include "learn/bench/resistor_bank.hpp"
#include "learn/bench/temperature_box.hpp"

namespace voltlap::plant {
namespace {

constexpr int kRepeatsMax = 400;  // of the last pulse: a cell that lasts longer has a wrong plan

VehicleParameters pack_of(const BenchPlan& plan, const BenchTest& test, const BenchCells& cells,
                          const TemperatureBox& box) {
  VehicleParameters out;
  out.cell = cells.cell;
  out.cell.convection_w_per_m2_k = box.convection_w_per_m2_k(cells.cell.convection_w_per_m2_k);
  out.battery.cells_in_series = plan.cells.count;
  out.battery.cells_in_parallel = 1;
  out.battery.initial_soc = plan.cells.initial_soc;
  out.battery.initial_temperature_c = test.temperature_c;
  out.battery.lookup_current_floor_a = 1e-3 * cells.cell.capacity_ah;  // a bench has a true zero
  out.battery.cells = cells.variations;
  out.environment.ambient_c = test.temperature_c;
  return out;
}

/// Readings between two rows of the table, and the row that they make.
class RowBuilder {
 public:
  RowBuilder(std::size_t cells, bool mean) : mean_(mean), voltage_(cells), true_voltage_(cells) {}

  void add(double current, double true_current, const std::vector<double>& voltage,
           const std::vector<double>& true_voltage) {
    if (count_ > 0 && !mean_) return;
    current_ += current;
    true_current_ += true_current;
    for (std::size_t cell = 0; cell < voltage_.size(); ++cell) {
      voltage_[cell] += voltage[cell];
      true_voltage_[cell] += true_voltage[cell];
    }
    ++count_;
  }
  void finish(double time_s, BenchRecord& record) {
    VOLTLAP_DEMAND(count_ > 0);
    const double share = 1.0 / count_;
    record.time_s.push_back(time_s);
    record.current_a.push_back(current_ * share);
    record.true_current_a.push_back(true_current_ * share);
    for (std::size_t cell = 0; cell < voltage_.size(); ++cell) {
      record.cells[cell].voltage_v.push_back(voltage_[cell] * share);
      record.cells[cell].true_voltage_v.push_back(true_voltage_[cell] * share);
      voltage_[cell] = true_voltage_[cell] = 0.0;
    }
    current_ = true_current_ = 0.0;
    count_ = 0;
  }

 private:
  bool mean_;
  std::vector<double> voltage_, true_voltage_;
  double current_ = 0.0, true_current_ = 0.0;
  int count_ = 0;
};

class VirtualBench {
 public:
  VirtualBench(const BenchPlan& plan, const BenchTest& test, const BenchCells& cells, const InstrumentErrors& errors,
            std::uint64_t noise_seed, const StopRequest& stop)
      : plan_(plan),
        stop_(stop),
        step_s_(1.0 / plan.sampling.rate_hz),
        steps_per_row_(static_cast<long>(std::lround(plan.sampling.rate_hz / plan.sampling.log_hz))),
        steps_per_minute_(static_cast<long>(std::lround(60.0 * plan.sampling.rate_hz))),
        box_(plan.box, test.temperature_c),
        pack_(pack_of(plan, test, cells, box_), cells.equal, step_s_),
        seen_(cells.equal ? 1 : static_cast<std::size_t>(plan.cells.count)),
        cooling_w_per_k_(plan.cells.count * cells.cell.surface_area_m2 *
                         box_.convection_w_per_m2_k(cells.cell.convection_w_per_m2_k)),
        instruments_(plan.instruments, errors, noise_seed),
        rule_(seen_, plan.rest.window_s, plan.sampling.rate_hz),
        row_(seen_, plan.sampling.resample == "mean"),
        voltage_(seen_),
        true_voltage_(seen_),
        thermistor_(seen_),
        temperature_(seen_) {
    VOLTLAP_DEMAND(step_s_ > 0.0 && steps_per_row_ > 0 && seen_ > 0);
    VOLTLAP_DEMAND(errors.cell_gain.size() >= seen_ && errors.temperature_offset_k.size() >= seen_);
    record_.test = test;
    record_.cells.resize(seen_);
    for (std::size_t cell = 0; cell < seen_; ++cell) {
      if (cell < cells.variations.size()) record_.cells[cell].variation = cells.variations[cell];
      record_.cells[cell].initial_soc = pack_.cell_soc(cell);
      record_.cells[cell].capacity_ah = pack_.capacity_ah(cell);
    }
    read_temperatures();
  }

  BenchRecord run(const Program& program) {
    hold_rest(plan_.test.initial_rest_s);
    bool on = perform(program.once);
    for (int i = 0; on && !program.again.empty(); ++i) {
      if (i == kRepeatsMax) {
        throw InputError(fmt::format("bench test {}", record_.test.name),
                         fmt::format("no cell at {} V after {} pulses more than planned",
                                     plan_.stop.cell_voltage_min_v, kRepeatsMax),
                         "the stop rule to end the test",
                         "Check schedule.step, test.capacity_ah and the cell file");
      }
      on = perform(program.again);
    }
    const bool stopped_by_rule = record_.end == TestEnd::kVoltage || record_.end == TestEnd::kTemperature;
    if (stopped_by_rule && record_.phases.back().load) rest();
    record_.charge_ah = pack_.charge_out_ah();
    VOLTLAP_DEMAND(increasing(record_.time_s) && record_.current_a.size() == record_.time_s.size());
    VOLTLAP_DEMAND(record_.cells.front().voltage_v.size() == record_.time_s.size());
    return std::move(record_);
  }

 private:
  bool perform(const std::vector<BenchSegment>& segments) {
    for (const BenchSegment& segment : segments) {
      switch (segment.kind) {
        case BenchSegmentKind::kRest:
          rest();
          break;
        case BenchSegmentKind::kWait:
          hold_rest(segment.duration_s);
          break;
        default:
          load(segment);
          break;
      }
      if (ended_) return false;
    }
    return true;
  }

  void load(const BenchSegment& segment) {
    begin(true);
    const long steps = std::max(1L, std::lround(segment.duration_s / step_s_));
    bool on = true;
    for (long i = 0; on && i < steps && !ended_; ++i) {
      step(settled_current(segment));
      pack_.renew(step_s_, box_.air_c());
      on = may_go_on(segment);
    }
    end();
  }

  /// Current of the coming step, with the cells' tables at that current: through a resistor each follows the other.
  double settled_current(const BenchSegment& segment) {
    constexpr double kSettled = 1e-7;  // of the current
    constexpr int kPassesMax = 20;
    double current = drawn_by(segment), before = 0.0;
    for (int pass = 0; pass < kPassesMax && std::abs(current - before) > kSettled * std::abs(current); ++pass) {
      before = current;
      pack_.renew_for(current);
      current = drawn_by(segment);
    }
    return current;
  }
  [[nodiscard]] double drawn_by(const BenchSegment& segment) const {
    return segment.kind == BenchSegmentKind::kCurrent ? segment.value
                                                      : resistor_current(pack_.thevenin(), segment.value);
  }

  /// The stop rules, on the readings.
  bool may_go_on(const BenchSegment& segment) {
    const auto lowest = std::min_element(voltage_.begin(), voltage_.end());
    const bool charging = segment.kind == BenchSegmentKind::kCurrent && segment.value < 0.0;
    if (!charging && *lowest <= plan_.stop.cell_voltage_min_v) {
      return finish(TestEnd::kVoltage, static_cast<std::size_t>(lowest - voltage_.begin()));
    }
    const auto hottest = std::max_element(thermistor_.begin(), thermistor_.end());
    if (*hottest >= plan_.stop.cell_temperature_max_c) {
      return finish(TestEnd::kTemperature, static_cast<std::size_t>(hottest - thermistor_.begin()));
    }
    return !(charging && *std::max_element(voltage_.begin(), voltage_.end()) >= plan_.stop.cell_voltage_max_v);
  }

  bool finish(TestEnd end, std::size_t cell) {
    record_.end = end;
    record_.end_cell = cell + 1;
    ended_ = true;
    return false;
  }

  void rest() {
    const bool fixed = plan_.rest.rule == "fixed";
    begin(false);
    rule_.begin();
    for (;;) {
      idle_step();
      const double elapsed = time_s() - record_.phases.back().begin_s;
      if (record_.end == TestEnd::kInterrupted || elapsed >= (fixed ? plan_.rest.seconds : plan_.rest.max_s)) break;
      if (!fixed && rule_.known() && rule_.rate_v_per_min() <= plan_.rest.rise_v_per_min && box_.ready(thermistor_))
        break;
    }
    end();
  }

  void hold_rest(double seconds) {
    const long steps = std::lround(seconds / step_s_);
    if (steps == 0) return;
    begin(false);
    for (long i = 0; i < steps && record_.end != TestEnd::kInterrupted; ++i) idle_step();
    end();
  }

  /// Without current nothing moves within a row but what the step itself carries: tables are renewed once a row.
  void idle_step() {
    step(0.0);
    rule_.add(voltage_);
    if (++idle_ < steps_per_row_) return;
    pack_.renew(step_s_ * static_cast<double>(std::exchange(idle_, 0)), box_.air_c());
  }

  void step(double current_a) {
    pack_.advance(current_a);
    ++steps_;
    for (std::size_t cell = 0; cell < seen_; ++cell) {
      true_voltage_[cell] = pack_.cell_voltage(cell);
      voltage_[cell] = instruments_.cell_voltage(cell, true_voltage_[cell]);
    }
    row_.add(instruments_.current(current_a), current_a, voltage_, true_voltage_);
    if (steps_ % steps_per_row_ == 0) write_row();
    if (stop_ && steps_ % steps_per_minute_ == 0 && stop_(time_s())) {
      record_.end = TestEnd::kInterrupted;
      ended_ = true;
    }
  }

  void write_row() {
    read_temperatures();
    box_.control(thermistor_);
    box_.follow(temperature_, cooling_w_per_k_);
    row_.finish(static_cast<double>(steps_ - steps_per_row_) * step_s_, record_);
    record_.ambient_c.push_back(instruments_.air_temperature(box_.air_c()));
    for (std::size_t cell = 0; cell < seen_; ++cell) {
      record_.cells[cell].temperature_c.push_back(thermistor_[cell]);
      record_.cells[cell].true_temperature_c.push_back(temperature_[cell]);
      record_.cells[cell].true_soc.push_back(pack_.cell_soc(cell));
    }
  }

  void read_temperatures() {
    for (std::size_t cell = 0; cell < seen_; ++cell) {
      temperature_[cell] = pack_.cell_temperature_c(cell);
      thermistor_[cell] = instruments_.cell_temperature(cell, pack_.surface_temperature_c(cell));
    }
  }

  void begin(bool load) {
    if (idle_ > 0) pack_.renew(step_s_ * static_cast<double>(std::exchange(idle_, 0)), box_.air_c());
    record_.phases.push_back({time_s(), time_s(), load, pack_.charge_out_ah(), 0.0});
  }
  void end() {
    BenchPhase& phase = record_.phases.back();
    phase.end_s = time_s();
    VOLTLAP_DEMAND(phase.end_s >= phase.begin_s);
    phase.charge_ah = pack_.charge_out_ah() - phase.charge_ah;
    phase.soc = pack_.soc_mean();
  }
  [[nodiscard]] double time_s() const { return static_cast<double>(steps_) * step_s_; }

  const BenchPlan& plan_;
  const StopRequest& stop_;
  double step_s_;
  long steps_per_row_, steps_per_minute_;
  TemperatureBox box_;
  Pack pack_;
  std::size_t seen_;  ///< cells that are integrated
  double cooling_w_per_k_;
  Instruments instruments_;
  RelaxationRule rule_;
  RowBuilder row_;
  BenchRecord record_;
  std::vector<double> voltage_, true_voltage_, thermistor_, temperature_;
  long steps_ = 0, idle_ = 0;
  bool ended_ = false;
};

}  // namespace

BenchRecord run_bench_test(const BenchPlan& plan, const BenchTest& test, const BenchCells& cells,
                          const InstrumentErrors& errors, std::uint64_t noise_seed, const StopRequest& stop) {
  return VirtualBench(plan, test, cells, errors, noise_seed, stop).run(program_of(plan, test));
}

}  // namespace voltlap::plant
