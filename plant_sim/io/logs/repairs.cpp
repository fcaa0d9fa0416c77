// SPDX-License-Identifier: Apache-2.0
#include "io/logs/repairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/number_text.hpp"
#include "core/signal.hpp"
#include "io/logs/current_sign.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSecondsPerHour = 3600.0;
constexpr double kCellVoltageMin = 0.5, kCellVoltageMax = 5.5;  // beyond any chemistry that a car carries

/// Sum of dI dV over the steps of the current, each part of a step's own size: negative when discharge is positive. A
/// step is a change over at least half a second: between rows of 100 Hz stands noise, and on a bus current and voltage
/// come in turn. One of less than a fiftieth of the largest current is noise beside the drift of a slow test.
/// No step counts for more than four usual ones: in an interval of a slow recorder an empty cell falls by itself.
double sign_evidence(const CellLog& log) {
  constexpr double kStep_s = 0.5, kRounding = 1e-6, kNoise = 0.02, kMostOfUsual = 4.0;
  double with = 0.0, size = 0.0, most = 0.0;
  std::vector<double> di_a, dv_v, sizes_v;
  for (const double current : log.current_a) most = std::max(most, std::abs(current));
  std::optional<std::size_t> from;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (log.gap[row]) from.reset();
    if (!std::isfinite(log.voltage_v[row])) continue;
    if (from && log.time_s[row] - log.time_s[*from] < kStep_s - kRounding) continue;
    if (from) {
      const double di = log.current_a[row] - log.current_a[*from], dv = log.voltage_v[row] - log.voltage_v[*from];
      if (std::abs(di) > kNoise * most) {
        di_a.push_back(di);
        dv_v.push_back(dv);
        sizes_v.push_back(std::abs(dv));
      }
    }
    from = row;
  }
  if (di_a.empty()) return 0.0;
  const double cap = kMostOfUsual * median(std::move(sizes_v));
  for (std::size_t k = 0; k < di_a.size(); ++k) {
    const double part = di_a[k] * std::clamp(dv_v[k], -cap, cap);
    with += part;
    size += std::abs(part);
  }
  return size > 0.0 ? with / size : 0.0;
}

/// 1 where the counter counts the way of the current's sign, else -1.
double counted_way(const CellLog& log) {
  double with = 0.0;
  for (std::size_t row = 1; row < log.charge_ah.size(); ++row) {
    const double step = log.charge_ah[row] - log.charge_ah[row - 1];
    if (std::isfinite(step)) with += step * (log.current_a[row] + log.current_a[row - 1]);
  }
  return with < 0.0 ? -1.0 : 1.0;
}

/// What a step of the counter must differ by from what the current says: a share of all that it counts, and no less
/// than its own steps.
double counter_tolerance(const CellLog& log) {
  constexpr double kUnseen = 1e-4, kSteps = 1.5;
  if (log.charge_ah.empty()) return 0.0;
  const auto [low, high] = std::minmax_element(log.charge_ah.begin(), log.charge_ah.end());
  double finest = *high - *low;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    const double step = std::abs(log.charge_ah[row] - log.charge_ah[row - 1]);
    if (step > 0.0) finest = std::min(finest, step);
  }
  return std::max(kUnseen * (*high - *low), kSteps * finest);
}

/// The counter moved by what neither hold of the current explains.
bool counter_disagrees(const CellLog& log, std::size_t row, double tolerance_ah) {
  constexpr double kShort = 5.0;  // s; within it a counter's step says little
  constexpr double kClear = 0.2;  // of the charge: a counter of another scale
  const double seconds = log.time_s[row] - log.time_s[row - 1];
  if (log.charge_ah.empty() || seconds < kShort) return false;
  const double counted = log.charge_ah[row] - log.charge_ah[row - 1], hours = seconds / kSecondsPerHour;
  const double before = log.current_a[row - 1] * hours, after = log.current_a[row] * hours;
  for (const double charge : {before, after, 0.5 * (before + after)}) {
    const double allowed = std::max(tolerance_ah, kClear * std::abs(charge));
    if (std::abs(counted - charge) <= allowed || std::abs(counted + charge) <= allowed) return false;
  }
  return true;
}

}  // namespace

namespace {

/// Parts of a recording, each with rising times, that follow each other when put in another order: a table that was
/// written newest first, shuffled, or pasted together the wrong way round. A clock that starts again gives parts that
/// overlap instead.
bool is_permutation(const std::vector<double>& time, const std::vector<std::size_t>& usable, double usual_s) {
  constexpr double kShuffled = 0.2, kDistinct = 0.95, kNear = 10.0, kRegular = 3.0;
  constexpr std::size_t kFewParts = 8;
  struct Part {
    double begin, end;
  };
  std::vector<Part> parts;
  for (const std::size_t row : usable) {
    if (parts.empty() || time[row] < parts.back().end) parts.push_back({time[row], time[row]});
    parts.back().end = time[row];
  }
  if (parts.size() < 2) return false;
  const auto n = static_cast<double>(usable.size());
  if (static_cast<double>(parts.size()) > kShuffled * n || parts.size() > kFewParts) {
    std::vector<double> sorted;
    for (const std::size_t row : usable) sorted.push_back(time[row]);
    std::sort(sorted.begin(), sorted.end());
    const std::vector<double> steps = differences(sorted);
    const auto distinct = static_cast<double>(std::unique(sorted.begin(), sorted.end()) - sorted.begin());
    const bool regular = quantile(steps, 0.9) < kRegular * quantile(steps, 0.1);
    if (distinct > kDistinct * n && (regular || static_cast<double>(parts.size()) > kShuffled * n)) return true;
  }
  std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.begin < b.begin; });
  for (std::size_t k = 1; k < parts.size(); ++k) {
    const double between = parts[k].begin - parts[k - 1].end;
    if (!(between > 0.0) || between > kNear * usual_s) return false;
  }
  return true;
}

/// Rows with time and current, in the order of the file, or of time where that is only another order.
std::vector<std::size_t> usable_rows(const std::vector<double>& time, const std::vector<double>& current,
                                     double usual_s, CellLog& log) {
  std::vector<std::size_t> out;
  for (std::size_t row = 0; row < time.size(); ++row) {
    if (std::isfinite(time[row]) && std::isfinite(current[row])) out.push_back(row);
  }
  if (!is_permutation(time, out, usual_s)) return out;
  std::stable_sort(out.begin(), out.end(), [&](std::size_t a, std::size_t b) { return time[a] < time[b]; });
  std::size_t moved = 0;
  for (std::size_t k = 1; k < out.size(); ++k) moved += out[k] < out[k - 1] ? 1 : 0;
  log.repairs.push_back(fmt::format("rows sorted by time: {} stood before an earlier one", moved));
  return out;
}

/// Median of the steps of time, forward or back.
double usual_interval(const std::vector<double>& time) {
  std::vector<double> steps;
  for (const double step : differences(time)) {
    if (std::isfinite(step) && step != 0.0) steps.push_back(std::abs(step));
  }
  return median(std::move(steps));
}

/// What is far longer than the recorder's habit. Testers write a row when something changes, so that such an interval
/// need not be a hole; one beyond ten minutes is taken for one.
class LongInterval {
 public:
  explicit LongInterval(const CellLog& log) : log_(log) {
    constexpr double kUsual = 0.9, kTimes = 10.0;  // of the intervals: a recorder may be slower at rest
    habit_s_ = kTimes * quantile(differences(log.time_s), kUsual);
    for (const double current : log.current_a) largest_a_ = std::max(largest_a_, std::abs(current));
  }
  /// A row when it is due: what lies between is not lost, only not written.
  [[nodiscard]] bool is_habit(std::size_t row) const { return seconds(row) <= habit_s_; }
  [[nodiscard]] double seconds(std::size_t row) const { return log_.time_s[row] - log_.time_s[row - 1]; }
  [[nodiscard]] bool is_gap(std::size_t row) const {
    constexpr double kLeast_s = 600.0;
    return seconds(row) > std::max(kLeast_s, habit_s_);
  }
  /// No gap, but long enough that its charge is a guess, which nothing has counted.
  [[nodiscard]] bool is_guess(std::size_t row) const {
    constexpr double kLeast_s = 10.0, kRest = 0.02;  // of the largest current
    const double flows_a = std::max(std::abs(log_.current_a[row - 1]), std::abs(log_.current_a[row]));
    return log_.charge_ah.empty() && flows_a > kRest * largest_a_ && seconds(row) > std::max(kLeast_s, habit_s_);
  }

 private:
  const CellLog& log_;
  double habit_s_ = 0.0, largest_a_ = 0.0;
};

}  // namespace

std::vector<std::size_t> rows_in_order(std::vector<double>& time, const std::vector<double>& current, CellLog& log,
                                       std::vector<bool>& joined) {
  VOLTLAP_DEMAND(time.size() == current.size());
  constexpr double kAhead = 10.0;  // usual intervals
  const double usual_s = usual_interval(time);
  const std::vector<std::size_t> usable = usable_rows(time, current, usual_s, log);
  std::vector<std::size_t> keep;
  std::size_t repeated = 0, backward = 0, ahead = 0, restarts = 0;
  double shift = 0.0;
  for (std::size_t k = 0; k < usable.size(); ++k) {
    const std::size_t row = usable[k];
    const bool last = k + 1 == usable.size();
    const double t = time[row] + shift, next = last ? t : time[usable[k + 1]] + shift;
    bool restarted = false;
    if (!keep.empty()) {
      const double before = time[keep.back()], back = before - t;
      if (back == 0.0) {
        ++repeated;
        continue;
      }
      if (t - before > kAhead * usual_s && next > before && next - before < 2.0 * kAhead * usual_s && next < t) {
        ++ahead;
        continue;
      }
      if (back > 0.0 && ((!last && next > before) || back < 1.0)) {
        ++backward;
        continue;
      }
      if (back > 0.0) {
        ++restarts;
        shift += back + kJoinPause;
        restarted = true;
      }
    }
    time[row] += shift;
    keep.push_back(row);
    joined.push_back(restarted);
  }
  const auto note = [&](std::size_t count, const char* what) {
    if (count > 0) log.repairs.push_back(fmt::format("{} {}", count, what));
  };
  note(time.size() - usable.size(), "rows without a time or current left out");
  note(repeated, "rows that repeat a time left out");
  note(backward, "rows with a time that goes back left out");
  note(ahead, "rows with a time that jumps ahead and comes back left out");
  note(restarts, "restarts of the clock: parts joined with 60 s between them, of which nothing is known");
  if (2 * repeated > usable.size()) {
    throw InputError(log.path,
                     fmt::format("{} of {} rows that repeat the time of the row before", repeated, usable.size()),
                     "a time for each row", "Export the time with seconds and their fraction, or name a finer column");
  }
  VOLTLAP_DEMAND(joined.size() == keep.size());
  return keep;
}

namespace {

/// How many cells would have such a voltage: none is ever above 4.4 V, and at the highest of a recording few below that
/// of a full iron phosphate cell, 3.4 V.
std::string likely_count(const std::vector<double>& voltage_v) {
  constexpr double kMost = 4.4, kLeast = 3.4, kMany = 1000.0;
  double high = 0.0;
  for (const double v : voltage_v) high = std::isfinite(v) ? std::max(high, v) : high;
  const double from = std::ceil(high / kMost), to = std::floor(high / kLeast);
  if (!(from >= 1.0 && to <= kMany)) return "";
  if (to <= from) return fmt::format(" {:.0f}, by the highest voltage", from);
  return fmt::format(" {:.0f} (cells of 4.4 V at most) to {:.0f} (3.4 V), by the highest voltage", from, to);
}

}  // namespace

void bring_to_one_cell(CellLog& log, int series) {
  VOLTLAP_DEMAND(series >= 1);
  double typical = median(log.voltage_v) / series;
  double scale = 1.0 / series;
  if (typical > 1e3 * kCellVoltageMin && typical < 1e3 * kCellVoltageMax) {
    log.repairs.push_back(fmt::format("voltage is in mV (median {:.0f}): divided by 1000", typical * series));
    scale /= 1000.0;
    typical /= 1000.0;
  }
  if (!(typical > kCellVoltageMin && typical < kCellVoltageMax)) {
    const double whole = typical * series;
    const std::string flag = "give --cells-in-series" + likely_count(log.voltage_v);
    throw InputError(log.path, fmt::format("a median voltage of {:.4g} V for {} cells in series", whole, series),
                     fmt::format("{} to {} V for each cell", kCellVoltageMin, kCellVoltageMax),
                     "Correct the unit in the role map, or " + flag);
  }
  std::size_t impossible = 0;
  for (double& v : log.voltage_v) {
    v *= scale;
    if (!std::isnan(v) && (v < kCellVoltageMin || v > kCellVoltageMax)) {
      v = std::nan("");
      ++impossible;
    }
  }
  if (impossible > 0)
    log.repairs.push_back(fmt::format("{} rows with a voltage of no cell are not used", impossible));
}

void settle_sign(CellLog& log, DischargeSign declared) {
  constexpr double kClear = 0.2, kContradicted = 0.5;
  const double whole = whole_sign_evidence(log);
  double evidence = std::abs(whole) < kClear ? sign_evidence(log) : whole;
  if (declared == DischargeSign::kNegative) evidence = -evidence;
  if (declared != DischargeSign::kAuto && evidence > kContradicted) {
    throw InputError(
        log.path, "a voltage that rises when the current rises",
        fmt::format("discharge {} as declared in {}", declared == DischargeSign::kPositive ? "\"+\"" : "\"-\"",
                    log.map),
        "The recording charges where discharge was declared: change the sign there, or set discharge = \"auto\"");
  }
  const bool flip = declared == DischargeSign::kNegative || (declared == DischargeSign::kAuto && evidence > 0.0);
  if (declared == DischargeSign::kAuto && std::abs(evidence) < kClear)
    log.repairs.emplace_back("the voltage hardly says which sign of the current is discharge: declare it in a map");
  if (!flip) return;
  for (double& i : log.current_a) i = -i;
  if (declared == DischargeSign::kAuto) log.repairs.emplace_back("sign of the current turned: charge was positive");
}

void settle_counter(CellLog& log) {
  if (log.charge_ah.empty()) return;
  if (counted_way(log) < 0.0) {
    for (double& q : log.charge_ah) q = -q;
    log.repairs.push_back("charge counter turned to count discharge");
  }
}

/// Rows before which the counter moved by what no current explains. None where it moves on the whole by a multiple of
/// the current: then its unit, or that of the time or the current, is another one.
static std::vector<bool> rows_of_the_counter(const CellLog& log, const std::vector<bool>& joined,
                                             const LongInterval& interval) {
  constexpr double kOtherUnit = 2.0;
  const double unseen_ah = counter_tolerance(log);
  std::vector<bool> out(log.rows(), false);
  double counted = 0.0, integrated = 0.0;
  for (std::size_t row = 1; row < log.rows() && !log.charge_ah.empty(); ++row) {
    if (joined[row]) continue;
    out[row] = counter_disagrees(log, row, unseen_ah);
    if (!interval.is_habit(row)) continue;
    counted += std::abs(log.charge_ah[row] - log.charge_ah[row - 1]);
    integrated += 0.5 * std::abs(log.current_a[row] + log.current_a[row - 1]) * interval.seconds(row) / kSecondsPerHour;
  }
  if (counted > kOtherUnit * integrated || integrated > kOtherUnit * counted) out.assign(log.rows(), false);
  return out;
}

void find_gaps(CellLog& log, const std::vector<bool>& joined) {
  VOLTLAP_DEMAND(joined.size() == log.rows());
  const LongInterval interval(log);
  const std::vector<bool> by_counter = rows_of_the_counter(log, joined, interval);
  log.gap.assign(log.rows(), false);
  std::size_t gaps = 0, guesses = 0;
  const double counts_discharge = counted_way(log);
  std::vector<std::pair<std::size_t, double>> counted;  // row, current by the counter
  double longest = 0.0, longest_guess = 0.0;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    const bool disagrees = by_counter[row];
    if (disagrees && interval.is_habit(row)) {
      const double step_ah = counts_discharge * (log.charge_ah[row] - log.charge_ah[row - 1]);
      counted.emplace_back(row, step_ah * kSecondsPerHour / interval.seconds(row));
    } else if (joined[row] || interval.is_gap(row) || disagrees) {
      log.gap[row] = true;
      ++gaps;
      longest = std::max(longest, interval.seconds(row));
    } else if (interval.is_guess(row)) {
      ++guesses;
      longest_guess = std::max(longest_guess, interval.seconds(row));
    }
  }
  for (const auto& [row, mean_a] : counted) log.current_a[row] = mean_a;
  if (!counted.empty()) {
    log.repairs.push_back(fmt::format(
        "{} rows whose current would move another charge than the counter says: the counter's mean is taken",
        counted.size()));
  }
  if (gaps > 0) {
    log.repairs.push_back(
        fmt::format("{} gaps (longest {} s): {}, nothing else is known of them", gaps, significant(longest, 3),
                    log.charge_ah.empty() ? "no charge assumed in them" : "charge from the counter"));
  }
  if (guesses > 0) {
    log.repairs.push_back(fmt::format("{} intervals under current far longer than the others (longest {} s): the "
                                      "current is taken as held over them; where rows were lost, that is wrong",
                                      guesses, significant(longest_guess, 3)));
  }
}

void note_held_rows(CellLog& log) {
  std::size_t repeated = 0, held = 0, moving = 0;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    if (std::abs(log.current_a[row]) < 1e-6) continue;
    const bool same = log.current_a[row] == log.current_a[row - 1];
    ++moving;
    held += same ? 1U : 0U;
    repeated += same && log.voltage_v[row] == log.voltage_v[row - 1] ? 1U : 0U;
  }
  if (held * 2 > moving || repeated * 20 < moving || moving == 0) return;
  log.repairs.push_back(fmt::format("{:.0f} % of the rows under current repeat the row before: used as they are",
                                    100.0 * static_cast<double>(repeated) / static_cast<double>(moving)));
}

}  // namespace voltlap::plant
