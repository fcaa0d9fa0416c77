// SPDX-License-Identifier: Apache-2.0
#include "race/report/run_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/parameter_table.hpp"

namespace voltlap::plant {
namespace {

constexpr std::string_view kCells = "battery.cells.", kFirstCell = "battery.cells.1.";

constexpr std::size_t kDistance = 0, kTime = 1;

void check_files(const std::vector<std::string>& files) {
  if (files.size() < 2 || files.size() > kRunsMax) {
    throw InputError("RUN.json", fmt::format("{} of them", files.size()),
                     fmt::format("2 to {} runs", kRunsMax), "Name the results of endurance --json, the first to "
                     "compare with");
  }
  for (std::size_t i = 1; i < files.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      std::error_code ignored;
      if (files[i] == files[j] || std::filesystem::equivalent(files[i], files[j], ignored)) {
        throw InputError("RUN.json", fmt::format("the same file twice ({})", files[i]), "a file for each run",
                         "Leave one out");
      }
    }
  }
}

/// Time over distance has a meaning only on one and the same course.
void check_courses(const std::vector<ComparedRun>& runs) {
  const auto course = [](const ComparedRun& run) {
    return run.course_length_m ? fmt::format("{}, {:.1f} m", run.course, *run.course_length_m)
                               : "the recorded drive " + run.course;
  };
  for (const ComparedRun& run : runs) {
    if (course(run) == course(runs[0])) continue;
    throw InputError(run.file + ", course", course(run), course(runs[0]) + ", as in " + runs[0].file,
                     "Compare runs of one course: a metre of one is no metre of another");
  }
}

/// The end of the path that tells the files apart.
std::vector<std::string> short_names(const std::vector<ComparedRun>& runs) {
  std::vector<std::string> names, stems;
  for (const ComparedRun& run : runs) stems.push_back(std::filesystem::path(run.file).stem().string());
  const bool differ = std::set<std::string>(stems.begin(), stems.end()).size() == stems.size();
  for (std::size_t i = 0; i < runs.size(); ++i) names.push_back(differ ? stems[i] : runs[i].file);
  return names;
}

std::string unit_of(const std::string& key) {
  const auto shown = [](std::string_view unit) { return unit == "-" || unit == "1" ? "" : std::string(unit); };
  if (const ParameterRow* row = find_parameter(key)) return shown(row->unit);
  const std::string field = key.substr(key.rfind('.') + 1);
  for (const IndexedRow& row : indexed_rows()) {
    if (key.starts_with(row.prefix) && row.field == field) return shown(row.unit);
  }
  return {};
}

void note_difference(const std::string& key, const std::string& unit, std::vector<std::string> values,
                     std::vector<InputDifference>& out) {
  if (std::all_of(values.begin(), values.end(), [&](const std::string& value) { return value == values[0]; })) return;
  out.push_back({key, unit, std::move(values)});
}

/// What a cell is that no key of its own speaks of; "-" for every other key.
std::string like_all_cells(const std::string& key) {
  static const std::map<std::string, std::string> values = [] {
    VehicleParameters plain;
    plain.battery.cells.resize(1);
    std::map<std::string, std::string> out;
    for (const auto& [name, value] : parameter_values(plain)) {
      if (name.starts_with(kFirstCell)) out.emplace(name.substr(kFirstCell.size()), value);
    }
    return out;
  }();
  if (!key.starts_with(kCells)) return "-";
  const auto known = values.find(key.substr(key.find('.', kCells.size()) + 1));
  return known == values.end() ? "-" : known->second;
}

std::vector<InputDifference> input_differences(const std::vector<ComparedRun>& runs) {
  std::vector<InputDifference> out;
  const auto flag = [&](const char* name, auto value) {
    std::vector<std::string> values;
    for (const ComparedRun& run : runs) values.push_back(value(run));
    note_difference(name, "", std::move(values), out);
  };
  flag("vehicle", [](const ComparedRun& run) { return run.vehicle; });
  flag("laps", [](const ComparedRun& run) { return fmt::format("{}", run.laps_asked); });
  flag("lap start", [](const ComparedRun& run) { return run.lap_start; });
  flag("cells", [](const ComparedRun& run) { return run.cells; });
  flag("seed", [](const ComparedRun& run) { return fmt::format("{}", run.seed); });
  flag("version", [](const ComparedRun& run) { return run.version; });

  std::vector<std::string> keys;  // in the order in which they first come
  std::set<std::string> known;
  std::vector<std::map<std::string, std::string>> values;
  for (const ComparedRun& run : runs) {
    values.emplace_back(run.parameters.begin(), run.parameters.end());
    for (const auto& [key, value] : run.parameters) {
      if (known.insert(key).second) keys.push_back(key);
    }
  }
  for (const std::string& key : keys) {
    std::vector<std::string> row;
    for (const auto& of_run : values) {
      const auto found = of_run.find(key);
      row.push_back(found == of_run.end() ? like_all_cells(key) : found->second);
    }
    note_difference(key, unit_of(key), std::move(row), out);
  }
  return out;
}

std::vector<ResultRow> result_rows(const std::vector<ComparedRun>& runs) {
  std::vector<ResultRow> out;
  for (std::size_t i = 0; i < compared_results().size(); ++i) {
    const ComparedResult& result = compared_results()[i];
    ResultRow& row = out.emplace_back(ResultRow{result.name, result.unit, result.digits, {}, {}});
    constexpr std::string_view kSums[] = {"total_time_s", "distance_m", "end_soc_pct", "energy_out_kwh"};
    const bool sum = std::find(std::begin(kSums), std::end(kSums), result.key) != std::end(kSums);
    for (const ComparedRun& run : runs) {
      row.values.emplace_back(run.results[i]);
      row.unlike.push_back(sum && (run.laps != runs[0].laps || run.finished != runs[0].finished));
    }
  }
  return out;
}

std::vector<ResultRow> limit_rows(const std::vector<ComparedRun>& runs) {
  std::vector<ResultRow> out;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (const auto& [name, active_s] : runs[r].limit_active_s) {
      if (active_s <= 0.0) continue;
      auto row = std::find_if(out.begin(), out.end(),
                              [&name = name](const ResultRow& known) { return known.name == name; });
      if (row == out.end()) {
        row = out.insert(out.end(), {name, "s", 2, std::vector<std::optional<double>>(runs.size(), 0.0)});
      }
      row->values[r] = active_s;
    }
  }
  return out;
}

std::vector<ResultRow> lap_table(const std::vector<ComparedRun>& runs, const char* unit, int digits,
                                 double ComparedLap::* value) {
  std::vector<ResultRow> out;
  std::size_t laps = 0;
  for (const ComparedRun& run : runs) laps = std::max(laps, run.lap_rows.size());
  for (std::size_t lap = 0; lap < laps; ++lap) {
    ResultRow& row = out.emplace_back(ResultRow{fmt::format("lap {}", lap + 1), unit, digits, {}});
    for (const ComparedRun& run : runs) {
      row.values.push_back(lap < run.lap_rows.size() ? std::optional(run.lap_rows[lap].*value) : std::nullopt);
    }
  }
  return out;
}

/// When the first run was at each point of a trace, as far as it came.
std::vector<double> delta(const ComparedRun& run, const ComparedRun& first) {
  const std::vector<double>&at = first.trace[kDistance], &time = first.trace[kTime];
  std::vector<double> out;
  std::size_t behind = 0;
  for (std::size_t i = 0; i < run.trace[kDistance].size(); ++i) {
    const double x = run.trace[kDistance][i];
    while (behind < at.size() && at[behind] < x) ++behind;
    if (behind == at.size()) break;
    const double part = behind == 0 || at[behind] == x ? 1.0 : (x - at[behind - 1]) / (at[behind] - at[behind - 1]);
    const double then = behind == 0 ? time[0] : time[behind - 1] + part * (time[behind] - time[behind - 1]);
    out.push_back(run.trace[kTime][i] - then);
  }
  VOLTLAP_DEMAND(all_finite(out));
  return out;
}

}  // namespace

RunComparison compare_runs(const std::vector<std::string>& files) {
  check_files(files);
  RunComparison out;
  for (const std::string& file : files) out.runs.push_back(read_compared_run(file));
  check_courses(out.runs);
  out.names = short_names(out.runs);
  out.inputs = input_differences(out.runs);
  out.results = result_rows(out.runs);
  out.limits = limit_rows(out.runs);
  out.lap_times = lap_table(out.runs, "s", 3, &ComparedLap::time_s);
  out.lap_energies = lap_table(out.runs, "kWh", 4, &ComparedLap::energy_kwh);
  ResultRow behind{"behind A where both had driven", "s", 3, {}};
  for (const ComparedRun& run : out.runs) {
    const std::vector<double>& of_run = out.delta_s.emplace_back(delta(run, out.runs[0]));
    behind.values.push_back(of_run.empty() ? std::nullopt : std::optional(of_run.back()));
  }
  out.results.insert(out.results.begin() + 1, behind);
  VOLTLAP_DEMAND(out.delta_s.size() == files.size() && out.names.size() == files.size());
  return out;
}

std::string run_letter(std::size_t run) { return std::string(1, static_cast<char>('A' + run)); }

std::string run_words(const ComparedRun& run) {
  std::string out = fmt::format("{} on {}", run.vehicle, run.course);
  if (run.lap_start != "drive") {
    out += fmt::format(", {} start, {} of {} laps", run.lap_start, run.laps, run.laps_asked);
  }
  if (!run.finished) out += fmt::format("; FAILED after {:.1f} s: {}", run.failure_time_s, run.failure_cause);
  return out;
}

std::string value_words(const ResultRow& row, std::optional<double> value, bool sign) {
  if (!value) return "-";
  const double scale = std::pow(10.0, row.digits);
  const double shown = std::round(*value * scale) / scale;
  const double signless = shown == 0.0 ? 0.0 : *value;  // no minus before zero
  return sign ? fmt::format("{:+.{}f}", signless, row.digits) : fmt::format("{:.{}f}", signless, row.digits);
}

std::optional<double> difference(const ResultRow& row, std::size_t run) {
  VOLTLAP_DEMAND(run < row.values.size());
  if (run < row.unlike.size() && row.unlike[run]) return std::nullopt;
  if (!row.values[run] || !row.values[0]) return std::nullopt;
  return *row.values[run] - *row.values[0];
}

}  // namespace voltlap::plant
