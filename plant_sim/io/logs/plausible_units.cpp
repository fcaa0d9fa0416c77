// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plausible_units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "io/logs/repairs.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSecondsPerDay = 86400.0, kSecondsPerHour = 3600.0;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

bool is_told(const RoleSource* source) { return source != nullptr && !source->unit.empty(); }

std::vector<double> finite_of(const std::vector<double>& values) {
  std::vector<double> out;
  std::copy_if(values.begin(), values.end(), std::back_inserter(out), [](double v) { return std::isfinite(v); });
  return out;
}

/// Median of |dV/dI| over the large steps from row to row; 0 without any.
double step_resistance(const std::vector<double>& current, const std::vector<double>& voltage) {
  constexpr double kLarge = 0.3;  // of the largest of the usual steps
  VOLTLAP_DEMAND(current.size() == voltage.size());
  std::vector<double> sizes, ratios;
  for (std::size_t row = 1; row < current.size(); ++row)
    sizes.push_back(std::abs(current[row] - current[row - 1]));
  const double large = kLarge * quantile(finite_of(sizes), 0.999);
  for (std::size_t row = 1; row < current.size(); ++row) {
    const double dv = voltage[row] - voltage[row - 1];
    if (sizes[row - 1] > 0.0 && sizes[row - 1] >= large && std::isfinite(dv) && dv != 0.0)
      ratios.push_back(std::abs(dv) / sizes[row - 1]);
  }
  return median(ratios);
}

void scale(std::vector<double>& values, double factor) {
  for (double& value : values) value *= factor;
}

}  // namespace

void settle_clock(std::vector<double>& time, const RoleSource& source, CellLog& log) {
  // Since 1970 in s: 2001 to 2096.
  constexpr double kFirst = 1e9, kLast = 4e9, kFirstDay = 20000.0, kLastDay = 80000.0, kLongestSpan = 60.0;
  const std::vector<double> all = finite_of(time);
  const double middle = median(all);
  for (const auto& [unit, size] : {std::pair{"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}) {
    if (middle * size < kFirst || middle * size > kLast) continue;
    if (!source.unit.empty()) {
      throw InputError(log.path, fmt::format("times of about {:.4g} s (\"{}\")", middle, source.column),
                       fmt::format("seconds; these are {} since 1970", unit),
                       "Correct the unit in the name or the map");
    }
    scale(time, size);
    log.repairs.push_back(fmt::format("time is in {} since 1970 (median {:.0f}): brought to s", unit, middle));
  }
  std::string name = source.column;
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  const auto [low, high] = std::minmax_element(all.begin(), all.end());
  const bool dated = name.find("date") != std::string::npos || name.find("time") != std::string::npos ||
                     name.find("dat") == 0;
  if (!all.empty() && source.unit.empty() && dated && *low > kFirstDay && *high < kLastDay &&
      *high - *low < kLongestSpan && median(differences(all)) > 0.0 && median(differences(all)) < 0.01) {
    const double origin = std::floor(*low);
    for (double& t : time) t = (t - origin) * kSecondsPerDay;
    log.repairs.push_back(
        fmt::format("time is in days of a spreadsheet ({:.0f}): brought to s since that day", origin));
  }
  std::size_t impossible = 0;
  for (double& t : time) {
    if (!std::isfinite(t) || std::abs(t) <= 1e11) continue;
    t = kNothing;
    ++impossible;
  }
  if (impossible > 0) log.repairs.push_back(fmt::format("{} times beyond 1e11 s are none", impossible));
}

namespace {

/// Up to three single rows far beyond all others to which the voltage does not answer: a bit that fell over.
void mask_spikes(std::vector<double>& current, const std::vector<double>& voltage, CellLog& log) {
  constexpr std::size_t kMost = 3;
  constexpr double kBeyond = 10.0, kAnswer = 3.0;  // times the others; a true one would be answered by as much
  std::vector<double> sizes, answers;
  for (std::size_t row = 0; row < current.size(); ++row) {
    if (std::isfinite(current[row])) sizes.push_back(std::abs(current[row]));
    const double dv = row > 0 ? std::abs(voltage[row] - voltage[row - 1]) : 0.0;
    if (std::isfinite(dv)) answers.push_back(dv);
  }
  if (sizes.size() <= 10 * kMost || answers.size() <= 10 * kMost) return;
  std::sort(sizes.begin(), sizes.end());
  std::sort(answers.begin(), answers.end());
  const double usual_answer = answers[answers.size() - 1 - 2 * kMost];
  const double usual = sizes[sizes.size() - 1 - kMost];
  for (std::size_t row = 1; row + 1 < current.size() && usual > 0.0; ++row) {
    const bool alone = std::abs(current[row - 1]) <= usual && std::abs(current[row + 1]) <= usual;
    const double answer =
        std::max(std::abs(voltage[row] - voltage[row - 1]), std::abs(voltage[row + 1] - voltage[row]));
    if (!(std::abs(current[row]) > kBeyond * usual) || !alone || !(answer < kAnswer * usual_answer)) continue;
    log.repairs.push_back(fmt::format("a single row of {:.4g} A that the voltage does not follow, others to {:.4g} A",
                                      current[row], usual));
    current[row] = kNothing;
  }
}

/// More than a few in a hundred are refused.
void mask_impossible(std::vector<double>& current, CellLog& log) {
  constexpr double kMasked = 0.05;
  const RoleRange range = role_range("current");
  std::size_t masked = 0, all = 0;
  double first = 0.0;
  for (double& i : current) {
    if (!std::isfinite(i)) continue;
    ++all;
    if (i >= range.min && i <= range.max) continue;
    if (masked++ == 0) first = i;
    i = kNothing;
  }
  if (masked == 0) return;
  const std::string text =
      fmt::format("{} of {} rows have an impossible current, such as {:.4g} A", masked, all, first);
  if (static_cast<double>(masked) > kMasked * static_cast<double>(all)) {
    throw InputError(log.path, text, fmt::format("currents of {:g} to {:g} A", range.min, range.max),
                     "Correct the unit or the scale of the current");
  }
  log.repairs.push_back(text + ": left out");
}

}  // namespace

void settle_current_unit(std::vector<double>& current, const std::vector<double>& voltage, const RoleSource& source,
                         const LogOptions& options, CellLog& log) {
  // Cells of cars have 0.1 mOhm (of hundreds of Ah) to 1 Ohm (a small one in the cold).
  constexpr double kLeastOhm = 80e-6, kLeastReal = 0.3e-3, kMostReal = 2.0, kWeak = 100.0, kMostAmpere = 1500.0,
                   kGarbage = 1e7;
  std::vector<double> sizes, likely = current;
  for (double& i : likely) {
    if (std::isfinite(i) && std::abs(i) < kGarbage) sizes.push_back(std::abs(i));
    else i = kNothing;
  }
  const double usual = quantile(sizes, 0.99) / options.cells_in_parallel;
  const double in_mv = std::abs(median(voltage)) / options.cells_in_series > 500.0 ? 1e-3 : 1.0;
  const double ohm =
      step_resistance(likely, voltage) * in_mv / options.cells_in_series * options.cells_in_parallel;
  const bool impossible = (ohm > 0.0 && ohm < kLeastOhm && usual > kWeak) || usual > kMostAmpere;
  const bool as_ma = usual / 1e3 <= kMostAmpere && (ohm == 0.0 || (ohm * 1e3 > kLeastReal && ohm * 1e3 < kMostReal));
  if (impossible && as_ma) {
    const std::string found = fmt::format("up to {:.4g} A at {:.3g} mOhm for each cell", usual, 1e3 * ohm);
    if (!source.unit.empty()) {
      throw InputError(fmt::format("{}, column \"{}\"", log.path, source.column), found,
                       "a current in " + source.unit + " as its name or the map says; as mA it would be a cell's",
                       "Name the column current_ma, give unit = \"mA\" in a map, or --cells-in-parallel of a pack");
    }
    scale(current, 1e-3);
    log.repairs.push_back(fmt::format("current is in mA ({}): divided by 1000", found));
  }
  mask_impossible(current, log);
  mask_spikes(current, voltage, log);
}

void settle_temperature_unit(std::vector<double>& temperature, const std::string& role, CellLog& log) {
  constexpr double kKelvinLow = 233.0, kKelvinHigh = 353.0, kZeroCelsius = 273.15, kHot = 60.0, kMasked = 0.2;
  const std::vector<double> all = finite_of(temperature);
  if (all.empty()) return;
  const auto [low, high] = std::minmax_element(all.begin(), all.end());
  if (*low > kKelvinLow && *high < kKelvinHigh) {
    for (double& t : temperature) t -= kZeroCelsius;
    log.repairs.push_back(fmt::format("{} is in K ({:.1f} to {:.1f}): brought to degC", role, *low, *high));
    return;
  }
  const RoleRange range = role_range(role);
  std::size_t masked = 0;
  for (double& t : temperature) {
    if (!std::isfinite(t) || within(t, range.min, range.max)) continue;
    t = kNothing;
    ++masked;
  }
  const std::string text = fmt::format("{} of {} readings of {} from {:.4g} to {:.4g} degC", masked, all.size(), role,
                                       *low, *high);
  if (static_cast<double>(masked) > kMasked * static_cast<double>(all.size())) {
    throw InputError(log.path, text + " are none", fmt::format("{:g} to {:g} degC", range.min, range.max),
                     "Correct the unit in the map (degC, K, degF), or leave the role out");
  }
  if (masked > 0) log.repairs.push_back(text + " are impossible: not used");
  if (masked == 0 && *low > kHot) {
    log.repairs.push_back(
        fmt::format("{} of {:.4g} to {:.4g} is read as degC; as degF it would be {:.1f} to {:.1f} degC "
                    "(unit = \"degF\" in a map)",
                    role, *low, *high, (*low - 32.0) / 1.8, (*high - 32.0) / 1.8));
  }
}

namespace {

/// What the counter counts for each Ah of current and time; nothing where it does not follow them.
std::optional<double> counter_ratio(const CellLog& log) {
  constexpr double kFollows = 0.9;
  double with = 0.0, counted = 0.0, integrated = 0.0;
  for (std::size_t row = 1; row < log.rows() && !log.charge_ah.empty(); ++row) {
    const double step = log.charge_ah[row] - log.charge_ah[row - 1];
    const double drawn = 0.5 * (log.current_a[row] + log.current_a[row - 1]) *
                         (log.time_s[row] - log.time_s[row - 1]) / kSecondsPerHour;
    if (log.gap[row] || !std::isfinite(step)) continue;
    with += step * drawn;
    counted += step * step;
    integrated += drawn * drawn;
  }
  const bool follows = with > kFollows * std::sqrt(counted * integrated) && integrated > 0.0;
  return follows ? std::optional(with / integrated) : std::nullopt;
}

bool is_about(double value, double wanted) { return std::abs(value / wanted - 1.0) < 0.1; }

/// Largest minus least charge drawn [Ah], gaps left out.
double charge_span_ah(const CellLog& log) {
  double drawn = 0.0, low = 0.0, high = 0.0;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    if (log.gap[row]) continue;
    drawn += 0.5 * (log.current_a[row] + log.current_a[row - 1]) * (log.time_s[row] - log.time_s[row - 1]) /
             kSecondsPerHour;
    low = std::min(low, drawn);
    high = std::max(high, drawn);
  }
  return high - low;
}

[[noreturn]] void refuse_units(const CellLog& log, const std::string& found, const char* units) {
  throw InputError(log.path, found, "units that agree with each other", std::string("Correct that of ") + units);
}

}  // namespace

/// Parts were joined with a pause in seconds, which is none of the recorder's numbers.
static void scale_time(CellLog& log, double seconds) {
  double shift_s = 0.0, before = log.time_s.empty() ? 0.0 : log.time_s.front();
  for (std::size_t row = 0; row < log.rows(); ++row) {
    const double step = log.time_s[row] - before;
    before = log.time_s[row];
    if (log.gap[row] && std::abs(step - kJoinPause) < 1e-6) shift_s += kJoinPause * (1.0 - seconds);
    log.time_s[row] = log.time_s[row] * seconds + shift_s;
  }
}

void settle_time_unit(CellLog& log, const RoleMap& map) {
  constexpr double kMostDrop = 6.0;  // V at one C
  const RoleSource *time = map.find("time"), *current = map.find("current");
  const RoleSource* counter = map.find("charge_ah");
  if (counter == nullptr) counter = map.find("discharged_ah");
  const auto ratio = counter_ratio(log);
  const auto time_is = [&](const char* unit, double seconds, const std::string& why) {
    scale_time(log, seconds);
    log.repairs.push_back(fmt::format("time is in {} ({}): brought to s", unit, why));
  };
  if (ratio) {
    const std::string why =
        fmt::format("the charge counter moves {:.3g} times as much as current and time say", *ratio);
    for (const auto& [unit, seconds] : {std::pair{"min", 60.0}, {"h", 3600.0}}) {
      if (!is_about(*ratio, seconds)) continue;
      if (is_told(time)) refuse_units(log, why, "the time or the current");
      return time_is(unit, seconds, why);
    }
    if (is_about(*ratio, 1e3)) {
      if (is_told(counter)) refuse_units(log, why, "the charge counter, the time or the current");
      scale(log.charge_ah, 1e-3);
      log.repairs.push_back("charge counter is in mAh: divided by 1000");
    } else if (is_about(*ratio, 1e-3)) {
      const bool only_time = !is_told(time) && is_told(current) && is_told(counter);
      if (!only_time) refuse_units(log, why, "the time (ms), the current (mA) or the counter");
      time_is("ms", 1e-3, why);
    }
    return;
  }
  const double drop = step_resistance(log.current_a, log.voltage_v) * charge_span_ah(log);
  if (drop <= kMostDrop) {
    // Too little charge is no contradiction: a recording may be short.
    if (!is_told(time)) log.repairs.emplace_back("time has no unit: taken as s");
    return;
  }
  const std::string why = fmt::format("{:.4g} Ah drawn, of which one C would cost {:.3g} V", charge_span_ah(log), drop);
  if (is_told(time) || drop / 1e3 > kMostDrop) refuse_units(log, why, "the time (ms?) or of the current");
  time_is("ms", 1e-3, why);
}

void fill_holes(std::vector<double>& values, const std::vector<double>& time_s, const std::string& role,
                CellLog& log) {
  if (values.empty()) return;
  VOLTLAP_DEMAND(values.size() == time_s.size());
  const auto holes =
      static_cast<std::size_t>(std::count_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); }));
  if (holes == 0) return;
  if (holes == values.size()) {
    log.repairs.push_back(fmt::format("no row has a {}", role));
    values.clear();
    return;
  }
  std::size_t before = values.size();  // none yet
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (!std::isfinite(values[row])) continue;
    const std::size_t from = before == values.size() ? 0 : before + 1;
    for (std::size_t hole = from; hole < row; ++hole) {
      const double share =
          before == values.size() ? 1.0 : (time_s[hole] - time_s[before]) / (time_s[row] - time_s[before]);
      values[hole] = before == values.size() ? values[row] : values[before] + share * (values[row] - values[before]);
    }
    before = row;
  }
  std::fill(values.begin() + static_cast<std::ptrdiff_t>(before) + 1, values.end(), values[before]);
  log.repairs.push_back(fmt::format("{} rows without a {}: taken from the rows around them", holes, role));
  VOLTLAP_DEMAND(all_finite(values));
}

}  // namespace voltlap::plant
