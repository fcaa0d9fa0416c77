// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/written_cell.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "io/atomic_file.hpp"
#include "io/temporary_folder.hpp"
#include "learn/identify/recording/quantised_temperature.hpp"
#include "learn/validate/cell_response.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

/// The recording as the fit saw it, on the SOC that the identification counts in: of several cells the common one.
MeasuredRun run_of(const CellLog& log, const RecordingResult& file, double capacity_ah) {
  RunOptions options;
  options.hold = file.hold;
  options.capacity_ah = capacity_ah;
  options.anchor = file.anchor;
  MeasuredRun run = make_run(log, options);
  VOLTLAP_DEMAND(run.rows() == file.trace.soc.size());
  const double low = file.trace.soc.minCoeff(), width = file.trace.soc.maxCoeff() - low;
  const double scale = width > 0.0 ? (file.soc_high - file.soc_low) / width : 1.0;
  run.soc = file.soc_low + scale * (file.trace.soc.array() - low);
  run.weight_s = file.trace.weight_s;
  VOLTLAP_DEMAND(run.reset.size() == run.at_rest_before.size());
  return run;
}

/// Squared errors over time, of the rows that a test takes.
struct Square {
  double v2_s = 0.0, s = 0.0;
  [[nodiscard]] double rms() const { return s > 0.0 ? std::sqrt(v2_s / s) : 0.0; }
  void add(const RecordingTrace& trace, Index row) {
    v2_s += trace.weight_s(row) * trace.error_v(row) * trace.error_v(row);
    s += trace.weight_s(row);
  }
};

double rms_from(const RecordingTrace& trace, Index first) {
  Square out;
  for (Index row = first; row < trace.error_v.size(); ++row) out.add(trace, row);
  return out.rms();
}

bool is_used(const RecordingResult& file, Index row) {
  return file.used.empty() || file.used.at(static_cast<std::size_t>(row));
}

Square square_of_used(const RecordingResult& file) {
  Square out;
  for (Index row = 0; row < file.trace.error_v.size(); ++row) {
    if (is_used(file, row)) out.add(file.trace, row);
  }
  return out;
}

void take_errors(const CellModel& model, const CellLog& log, const OperatingPoint& point, RecordingResult& file) {
  const MeasuredRun run = run_of(log, file, point.result.model.capacity_ah);
  const CellResponse response = respond(model, run, {log, file.coldest_c}, file.states_v);
  ReadBack found{file.rms_v, 0.0, square_of_used(file).rms()};
  file.trace.error_v = response.voltage - run.voltage_v;
  found.used_rms_v = square_of_used(file).rms();
  file.read_back = found;
  file.rms_v = rms_from(file.trace, 0);
  file.rms_pulses_v = rms_from(file.trace, static_cast<Index>(file.anchor.row));
}

/// Of the rows that the fit took, of all recordings.
double rms_of_used(const std::vector<RecordingResult>& files) {
  Square out;
  for (const RecordingResult& file : files) {
    const Square one = square_of_used(file);
    out.v2_s += one.v2_s;
    out.s += one.s;
  }
  return out.rms();
}

/// The recording with the highest voltage, and its middle one.
std::pair<std::string, double> highest_recording(const CellIdentification& identified) {
  std::pair<std::string, double> out{"", -1.0};
  for (const OperatingPoint& point : identified.points) {
    for (const RecordingResult& file : point.result.files) {
      const double middle = median({file.trace.voltage_v.begin(), file.trace.voltage_v.end()});
      if (middle > out.second) out = {file.path, middle};
    }
  }
  return out;
}

/// What to do about voltages that are those of no cell.
std::string other_count(double middle_v, int cells_in_series) {
  constexpr double kUsual = 3.7, kLow = 1.5, kHigh = 4.4;
  const double count = std::round(middle_v * cells_in_series / kUsual);
  if (middle_v > kLow && middle_v < kHigh) {
    return "The recordings do not tell this OCV: check --cells-in-parallel, or give --capacity, --ocv, or a recording "
           "that rests in between";
  }
  return fmt::format("Check the counts: its voltage has {:.3g} V a cell in the middle; --cells-in-series {:.0f} makes "
                     "it {:g} V",
                     middle_v, std::max(1.0, count), kUsual);
}

}  // namespace

CellParameters read_back(const std::string& toml, const DataFolder& data) {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/identified.toml";
  AtomicFile file(path);
  file.write(toml);
  file.commit();
  try {
    return load_cell(data, path, "identify");
  } catch (const InputError& refused) {
    // The folder is gone with this: what is wrong is the number, not a file that anybody could correct.
    const std::string what(refused.what()), named = path + ":";
    const std::size_t at = what.find(named), key = at == std::string::npos ? at : what.find(", ", at);
    if (key == std::string::npos) throw;
    throw InputError("The cell that these recordings would make is none: " + what.substr(key + 2) +
                     " Check --cells-in-series and --cells-in-parallel, and the units of the columns.");
  }
}

void take_errors_of_file(const CellParameters& file, const std::vector<CellIdentification>& each,
                         CellIdentification& identified) {
  const CellModel model(file);
  for (std::size_t g = 0; g < identified.points.size(); ++g) {
    OperatingPoint& point = identified.points[g];
    std::vector<const CellLog*> logs;
    for (const CellIdentification& cell : each) {
      for (const CellLog& log : cell.points.at(g).logs) logs.push_back(&log);
    }
    auto log = logs.begin();
    for (RecordingResult& recording : point.result.files) {
      // In the same order; one that contradicts the others was left out.
      log = std::find_if(log, logs.end(), [&](const CellLog* one) {
        return one->path == recording.path && static_cast<Index>(one->rows()) == recording.rows;
      });
      VOLTLAP_DEMAND(log != logs.end());
      CellLog seen = **log++;
      smooth_quantised_temperature(seen);
      take_errors(model, seen, point, recording);
    }
    point.result.rms_v = rms_of_used(point.result.files);
  }
}

void require_possible_cell(const CellParameters& file, const CellIdentification& identified, int cells_in_series) {
  constexpr double kLowest_v = 1.0, kHighest_v = 5.0, kLeast_ohm = 1e-6, kMost_ohm = 10.0, kMost_s = 2e5;
  const auto [path, middle_v] = highest_recording(identified);
  const auto refuse = [place = path](const std::string& found, const std::string& expected, const std::string& what) {
    throw InputError(place, found, expected, what + ". Nothing was written");
  };
  for (std::size_t k = 0; k < file.ocv_v.size(); ++k) {
    const double v = file.ocv_v[k];
    if (v > kLowest_v && v < kHighest_v) continue;
    refuse(fmt::format("an open-circuit voltage of {:.3g} V a cell at SOC {:.3g}", v, file.ocv_soc[k]),
           fmt::format("{:g} to {:g} V a cell", kLowest_v, kHighest_v), other_count(middle_v, cells_in_series));
  }
  const auto values = [](const CellParameterMap& map) { return map.table.empty() ? map.value : map.table; };
  const std::vector<double> r0 = values(file.r0_ohm);
  const double most = *std::max_element(r0.begin(), r0.end());
  if (most < kLeast_ohm || most > kMost_ohm) {
    refuse(fmt::format("a resistance R0 of at most {:.3g} mOhm", 1e3 * most),
           fmt::format("{:g} to {:g} mOhm of a cell", 1e3 * kLeast_ohm, 1e3 * kMost_ohm),
           "Check the unit of the current, --cells-in-parallel, and that voltage and current are of one battery");
  }
  for (const CellBranch& branch : file.branches) {
    for (const double tau : values(branch.tau_s)) {
      if (tau > 0.0 && tau < kMost_s) continue;
      refuse(fmt::format("a time constant of {:.3g} s", tau), fmt::format("more than 0 and less than {:g} s", kMost_s),
             "Give a recording with longer rests, or fewer branches (--rc 1)");
    }
  }
}

double lost_by_file(const CellIdentification& identified) {
  constexpr double kTimes = 2.0, kBeside_v = 2e-3;
  double out = 0.0;
  for (const OperatingPoint& point : identified.points) {
    for (const RecordingResult& file : point.result.files) {
      if (!file.read_back) continue;
      const double file_v = file.read_back->used_rms_v;
      if (file_v > kTimes * file.read_back->fit_used_rms_v + kBeside_v) out = std::max(out, file_v);
    }
  }
  return out;
}

void require_possible_soc(const CellIdentification& identified) {
  constexpr double kFar = 0.25, kBeyond = 0.05;  // cold, aged, counted by another counter
  constexpr double kMissed_v = 0.05;             // and by so much the file misses what was not fitted
  for (const OperatingPoint& point : identified.points) {
    for (const RecordingResult& file : point.result.files) {
      const double beyond = std::max(-file.soc_low, file.soc_high - 1.0);
      if (beyond < kBeyond || (beyond < kFar && file.rms_pulses_v < kMissed_v)) continue;
      throw InputError(file.path,
                       fmt::format("a state of charge from {:.2f} to {:.2f} with a capacity of {:.4g} Ah", file.soc_low,
                                   file.soc_high, point.result.model.capacity_ah),
                       "0 to 1",
                       fmt::format("The file would miss it by {:.0f} mV. Correct or tell --capacity, or leave out a "
                                   "recording of another cell. Nothing was written",
                                   1e3 * file.rms_pulses_v));
    }
  }
}

void require_file_follows(const CellIdentification& identified) {
  constexpr double kMissed_v = 0.15, kTimes = 5.0, kBeside_v = 0.02;
  for (const OperatingPoint& point : identified.points) {
    for (const RecordingResult& file : point.result.files) {
      std::vector<double> sizes;
      for (Index row = 0; row < file.trace.error_v.size(); ++row) {
        if (is_used(file, row) && file.trace.weight_s(row) > 0.0) sizes.push_back(std::abs(file.trace.error_v(row)));
      }
      const double missed_v = median(std::move(sizes));
      if (missed_v > kMissed_v) {
        throw InputError(file.path,
                         fmt::format("a model that misses half of its rows by more than {:.0f} mV", 1e3 * missed_v),
                         fmt::format("at most {:.0f} mV", 1e3 * kMissed_v),
                         "Check --cells-in-series, --cells-in-parallel, the units, and that voltage and current are of "
                         "one battery. Nothing was written");
      }
      if (!file.read_back) continue;
      const double file_v = file.read_back->used_rms_v, fit_v = file.read_back->fit_used_rms_v;
      if (file_v <= kTimes * fit_v + kBeside_v) continue;
      throw InputError(
          file.path,
          fmt::format("an RMS of {:.1f} mV by the cell file read back, {:.1f} mV in the fit", 1e3 * file_v,
                      1e3 * fit_v),
          fmt::format("at most {:g} times the fit's and {:.0f} mV", kTimes, 1e3 * kBeside_v),
          "The file does not hold what was fitted: tell the temperature (--temperature), the cell's body (--mass, "
          "--size) or fewer branches (--rc 1). Nothing was written");
    }
  }
}

}  // namespace voltlap::plant
