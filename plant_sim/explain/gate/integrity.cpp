// SPDX-License-Identifier: Apache-2.0
#include "explain/gate/integrity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "car/battery/cell_tables.hpp"
#include "core/signal.hpp"
#include "explain/gate/frozen.hpp"
#include "explain/say/numbers.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kGap = 5.0;         // usual intervals that make a gap
constexpr double kBurst = 2.0;       // mean over median interval from which rows come in bursts
constexpr double kLeastTime = 60.0;  // s that a judgement needs
constexpr double kLeastRatio = 1.5;  // a finding must exceed the references' by this

struct Range {
  double low, high, usual_step;
  const char* unit;
};

/// What a healthy sensor of this role can say.
Range range_of(const std::string& role, const Model& model) {
  const CellParameters& cell = model.world.car.cell;
  const double series = std::max(1, model.world.car.battery.cells_in_series);
  if (role == "voltage" || role.starts_with("cell_voltage_")) {
    return {cell.voltage_min_v - 1.2, cell.voltage_max_v + 0.25, 5e-3, "V"};
  }
  // A unit that compensates what it publishes says, under a current, what no cell has.
  constexpr double kPublished = 1.5;
  if (role == "pack_voltage")
    return {series * (cell.voltage_min_v - 1.0), kPublished * series * cell.voltage_max_v, 0.5, "V"};
  if (role.starts_with("temperature_") || role == "ambient") return {-45.0, 110.0, 1.0, "K"};
  if (role == "accelerator" || role == "brake") return {-0.1, 1.1, 0.05, "1"};
  if (role == "current") return {-5000.0, 5000.0, 1.0, "A"};
  if (role == "speed") return {-5.0, 100.0, 0.3, "m/s"};
  return {-1e12, 1e12, 1e12, "1"};
}

void mask_impossible(Recording& log, const Sensor& sensor, const Range& range) {
  const VectorXd& values = sensor.values;
  for (Index row = 0; row < values.size();) {
    const auto bad = [&](Index at) {
      return std::isfinite(values(at)) && (values(at) < range.low || values(at) > range.high);
    };
    if (!bad(row)) {
      ++row;
      continue;
    }
    Index last = row;
    while (last < values.size() && bad(last)) ++last;
    mask(log, sensor, row, last, fmt::format("{:.3g} {} is no reading of this sensor", values(row), range.unit));
    row = last;
  }
}

/// Behind open contactors a bus discharges or is charged up: its voltage moves though no current flows, faster than
/// any cell relaxes. From a fall until the voltage is back, or from a rise beyond all that a current ever showed (a
/// motor that turns charges a bus), and from the beginning to the last rise before the first current.
void mask_open_contactors(Recording& log, const Sensor& sensor, const VectorXd& current) {
  const VectorXd& values = sensor.values;
  constexpr double kNoCurrent = 0.02, kJump = 0.015;  // of the largest current; of the voltage, between two rows
  constexpr double kBeyond = 1.05;                    // of the largest voltage under a current
  const double quiet = kNoCurrent * current.cwiseAbs().maxCoeff();
  const auto rests = [&](Index row) {
    return std::abs(current(row)) <= quiet && std::abs(current(row - 1)) <= quiet;
  };
  double highest = 0.0;
  for (Index row = 0; row < values.size(); ++row) {
    if (std::abs(current(row)) > quiet && values(row) > highest) highest = values(row);
  }
  const std::string why = "the voltage moves without a current: the contactors are open";
  Index closed = 0;
  for (Index row = 1; row < values.size() && rests(row); ++row) {
    if (values(row) - values(row - 1) > kJump * values(row)) closed = row;
  }
  if (closed > 0) mask(log, sensor, 0, closed, why);
  for (Index row = closed + 1; row < values.size(); ++row) {
    const double before = values(row - 1);
    const bool falls = before - values(row) > kJump * before,
               rises = values(row) - before > kJump * before && highest > 0.0 && values(row) > kBeyond * highest;
    if (!rests(row) || !(falls || rises)) continue;
    const auto is_back = [&](double v) {
      return v > (1.0 - kJump) * before && (falls || v < (1.0 + kJump) * before);
    };
    Index last = row;
    while (last < values.size() && std::abs(current(last)) <= quiet && !is_back(values(last))) ++last;
    mask(log, sensor, row, last, why);
    row = last;
  }
}

/// Current that a voltage of this role must show: twice its step over the resistance that the model gives it.
double least_shown_a(const std::string& role, const Model& model, double step) {
  const CellParameters& cell = model.world.car.cell;
  const BatterySection& battery = model.world.car.battery;
  const double r0 = CellTables(cell).circuit(0.5, cell.reference_temperature_c, cell.reference_current_a).r0_ohm;
  const double cells = role == "pack_voltage" ? std::max(1, battery.cells_in_series) : 1;
  return 2.0 * step * battery.cells_in_parallel / (cells * r0);
}

void find_gaps(Recording& log, std::vector<GateFinding>& findings) {
  std::vector<double> intervals;
  for (Index row = 1; row < log.rows(); ++row) intervals.push_back(log.time_s(row) - log.time_s(row - 1));
  const double mean = (log.time_s(log.rows() - 1) - log.time_s(0)) / static_cast<double>(log.rows() - 1);
  // A logger that writes in bursts: the distance of its rows says nothing about frames that are missing.
  const bool bursts = mean > kBurst * median(intervals);
  const double usual = bursts ? mean : median(intervals);
  double missing = 0.0, count = 0.0;
  for (Index row = 1; row < log.rows(); ++row) {
    const double interval = log.time_s(row) - log.time_s(row - 1);
    if (interval > 1.8 * usual && !bursts) missing += std::round(interval / usual) - 1.0;
    if (interval <= std::max(kGap * usual, 0.5)) continue;
    log.masked.push_back(
        {"time", log.time_s(row - 1), log.time_s(row), fmt::format("nothing recorded for {:.1f} s", interval)});
    count += 1.0;
  }
  for (const Masked& masked : log.masked) count += masked.reason.starts_with("time ") ? 1.0 : 0.0;
  const double rows = static_cast<double>(log.rows());
  if (missing + count > 0.0) {
    findings.push_back(
        {"dropped_or_late_frames", "time", "count", missing + count, "1", missing > 0.005 * rows || count > 2.0});
  }
}

double holes_in(const VectorXd& values) {
  return static_cast<double>(
      std::count_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); }));
}

/// Before a first reading, which a slow message gives a few seconds after the others, there is no hole.
void find_holes(const std::string& role, const VectorXd& time_s, const VectorXd& values,
                std::vector<GateFinding>& findings) {
  constexpr double kFirst_s = 5.0;
  const auto rows = static_cast<double>(values.size());
  Index first = 0;
  while (first < values.size() && !std::isfinite(values(first)) && time_s(first) <= time_s(0) + kFirst_s) ++first;
  const double holes = holes_in(values.tail(values.size() - first));
  if (holes > 0.0 && holes < rows)
    findings.push_back({"dropped_or_late_frames", role, "count", holes, "1", holes > 0.005 * rows});
}

/// NaN that came with the log: a line for each signal, one for all cells or thermistors.
void note_holes(Recording& log) {
  std::map<std::string, std::vector<std::pair<std::string, double>>> by_stem;
  for (const auto& [role, values] : log.signals) {
    const double holes = holes_in(values);
    if (holes <= 0.0) continue;
    const bool numbered = role.starts_with("cell_voltage_") || role.starts_with("temperature_");
    by_stem[numbered ? role.substr(0, role.rfind('_')) : role].emplace_back(role, holes);
  }
  for (const auto& [stem, holes] : by_stem) {
    const auto fewer = [](const auto& x, const auto& y) { return x.second < y.second; };
    const double least = std::min_element(holes.begin(), holes.end(), fewer)->second;
    const double most = std::max_element(holes.begin(), holes.end(), fewer)->second;
    const std::string whose =
        holes.size() == 1 ? channel_words(holes.front().first)
                          : fmt::format("{} {}", holes.size(), stem == "temperature" ? "thermistors" : "cells");
    const std::string count =
        least < most ? fmt::format("{:.0f} to {:.0f}", least, most) : fmt::format("{:.0f}", most);
    log.repairs.push_back(fmt::format("{}: {} of {} rows without a value, not used", whose, count, log.rows()));
  }
}

void judge_amount(Gated& out) {
  const Recording& log = out.log;
  const VectorXd& current = *log.find("current");
  double most = 0.0, usable = 0.0;
  for (Index row = 1; row < log.rows(); ++row) {
    if (!std::isfinite(current(row))) continue;
    most = std::max(most, std::abs(current(row) - current(row - 1)));
    usable += std::min(1.0, log.time_s(row) - log.time_s(row - 1));
  }
  if (usable < kLeastTime) {
    out.enough = fmt::format("The log is too short to tell anything: {:.0f} s are usable.", usable);
    out.drive = "two laps with hard acceleration, and a rest of five minutes at each end";
  } else if (most <= 0.0) {
    out.enough = "The log is too calm to tell anything: its current never changes.";
    out.drive = "hard pulls of ten seconds with rests between them";
  }
}

}  // namespace

double step_of(const VectorXd& values) {
  std::set<double> different;
  double last = std::numeric_limits<double>::quiet_NaN();  // most rows hold what was read before
  for (const double v : values) {
    if (v == last || !std::isfinite(v)) continue;
    last = v;
    different.insert(std::round(v * 1e7) / 1e7);
    if (different.size() > 4000) return 0.0;
  }
  if (different.size() < 3) return 0.0;
  std::vector<double> gaps;
  for (auto it = std::next(different.begin()); it != different.end(); ++it) gaps.push_back(*it - *std::prev(it));
  std::sort(gaps.begin(), gaps.end());
  return gaps[gaps.size() / 10];
}

/// Says that cells are read one after the other.
static void note_turns(Recording& log) {
  double oldest = 0.0;
  for (const auto& [role, age] : log.age_s) {
    if (role.starts_with("cell_voltage_") && age.size() > 0) oldest = std::max(oldest, age.mean());
  }
  if (oldest <= 0.0) return;
  log.repairs.push_back(fmt::format(
      "the cells are read in turn, on average up to {:.2g} s before the current: each is compared at its own time",
      oldest));
}

Gated integrity_gate(Recording raw, const Model& model) {
  Gated out;
  out.log = std::move(raw);
  find_gaps(out.log, out.findings);
  for (const auto& [role, values] : out.log.signals) find_holes(role, out.log.time_s, values, out.findings);
  note_holes(out.log);
  VectorXd moving = *out.log.find("current");
  double last = 0.0, most = 0.0;
  for (double& v : moving) {
    if (!std::isfinite(v)) v = last;
    last = v;
    most = std::max(most, std::abs(v));
  }
  const VectorXd* volts = nullptr;
  for (const char* role : {"voltage", "pack_voltage", "cell_voltage_1"}) {
    if (volts == nullptr) volts = out.log.find(role);
  }
  VectorXd voltage = volts != nullptr ? *volts : moving;
  last = voltage(0);
  for (double& v : voltage) {
    if (!std::isfinite(v)) v = last;
    last = v;
  }
  const double swing = voltage.maxCoeff() - voltage.minCoeff();
  for (auto& [role, values] : out.log.signals) {
    const Range range = range_of(role, model);
    const Sensor sensor{role, values, range.unit};
    mask_impossible(out.log, sensor, range);
    if (role == "current") {
      mask_frozen(out.log, sensor, {voltage, 0.3 * swing}, out.findings);
    } else if (role == "voltage" || role == "pack_voltage" || role.starts_with("cell_voltage_")) {
      const double coarsest = std::max(range.usual_step, step_of(values));
      const double moved_by = std::max(0.3 * most, least_shown_a(role, model, coarsest));
      mask_frozen(out.log, sensor, {moving, moved_by}, out.findings);
      if (role != "pack_voltage") mask_standing(out.log, sensor, out.findings);  // at rest too
    } else if (role.starts_with("temperature_")) {
      mask_standing(out.log, sensor, out.findings);
    }
    if (role == "pack_voltage" || role == "bus_voltage") mask_open_contactors(out.log, sensor, moving);
    const double step = step_of(values);
    if (step > 0.0 && range.usual_step < 1e9) {
      out.findings.push_back({"quantisation", role, "step", step, range.unit, step > 2.0 * range.usual_step});
    }
  }
  judge_amount(out);
  note_turns(out.log);
  return out;
}

namespace {

/// "cell 3 is frozen for 4.2 s"
std::string said_of(const GateFinding& finding) {
  const std::string whose = channel_words(finding.channel);
  if (finding.cause == "quantisation")
    return fmt::format("{} is recorded in steps of {:.3g} {}", whose, finding.value, finding.unit);
  if (finding.cause == "frozen_signal") return fmt::format("{} is frozen for {:.1f} s", whose, finding.value);
  return finding.channel == "time" ? fmt::format("{:.0f} rows are missing or late", finding.value)
                                   : fmt::format("{:.0f} rows of {} are missing or late", finding.value, whose);
}

}  // namespace

std::vector<FoundCause> unusual_findings(const std::vector<GateFinding>& findings,
                                         const std::vector<std::vector<GateFinding>>& references) {
  std::vector<FoundCause> out;
  for (const GateFinding& finding : findings) {
    double usual = 0.0;
    for (const auto& reference : references) {
      for (const GateFinding& theirs : reference) {
        if (theirs.cause == finding.cause && theirs.channel == finding.channel)
          usual = std::max(usual, theirs.value);
      }
    }
    // A count is worth a word by its share of the rows alone: a few are lost in any log.
    const bool counted = finding.measure == "count" && !finding.worth_telling;
    const bool tell = references.empty() ? finding.worth_telling : finding.value > kLeastRatio * usual && !counted;
    if (!tell || (!references.empty() && finding.cause == "quantisation" && usual <= 0.0 && !finding.worth_telling))
      continue;
    const bool known =
        std::any_of(out.begin(), out.end(), [&](const FoundCause& f) { return f.name == finding.cause; });
    if (known) continue;  // one line a kind; the stretches of the others are among the masked ones
    FoundCause found;
    found.name = finding.cause;
    found.parameters.push_back({"channel", "name", 0.0, 0.0, 0.0, finding.channel});
    found.parameters.push_back({finding.measure, finding.unit, finding.value, finding.value, finding.value, ""});
    found.probability = 0.99;
    found.says = said_of(finding);
    out.push_back(std::move(found));
  }
  return out;
}

}  // namespace voltlap::plant
