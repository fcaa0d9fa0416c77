// SPDX-License-Identifier: Apache-2.0
// Runs of one course over each other: what differs in what they were given and in what they came to, and the time
// that each is behind the first, by distance.
//
//   delta(x) = t_run(x) - t_first(x) [s], positive where the run is behind; up to where the shorter of both ends
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "race/report/compared_run.hpp"

namespace voltlap::plant {

constexpr std::size_t kRunsMax = 5;

/// An input that is not the same in all runs.
struct InputDifference {
  std::string key, unit;            ///< a parameter's key, or the name of a flag's value
  std::vector<std::string> values;  ///< by run; "-" where the run does not have it
};

/// A number of every run. None where a run has no such lap.
struct ResultRow {
  std::string name, unit;
  int digits;
  std::vector<std::optional<double>> values;
  std::vector<bool> unlike{};  ///< by run: it drove another number of laps, and this is a sum over them
};

struct RunComparison {
  std::vector<ComparedRun> runs;
  std::vector<std::string> names;  ///< by run: its file, as short as it can be told from the others
  std::vector<InputDifference> inputs;
  std::vector<ResultRow> results;
  std::vector<ResultRow> limits;  ///< time active; those that bound in one run at least
  std::vector<ResultRow> lap_times, lap_energies;
  std::vector<std::vector<double>> delta_s;  ///< by run, at the first points of its trace
};

/// Two to kRunsMax runs. Throws InputError for more or fewer, the same file twice, or other courses than the first's.
[[nodiscard]] RunComparison compare_runs(const std::vector<std::string>& files);

/// "A", "B" ...: how a run is called in tables.
[[nodiscard]] std::string run_letter(std::size_t run);
/// "vtm16e on michigan_2015, flying start, 27 of 27 laps", and why it ended when it failed.
[[nodiscard]] std::string run_words(const ComparedRun& run);
/// A value as it is shown, "-" for none; `sign` for a difference.
[[nodiscard]] std::string value_words(const ResultRow& row, std::optional<double> value, bool sign = false);
[[nodiscard]] std::optional<double> difference(const ResultRow& row, std::size_t run);

/// Terminal.
[[nodiscard]] std::string comparison_text(const RunComparison& comparison);
/// JSON text with a final newline.
[[nodiscard]] std::string comparison_json(const RunComparison& comparison);
/// One HTML file.
[[nodiscard]] std::string comparison_page(const RunComparison& comparison);

}  // namespace voltlap::plant
