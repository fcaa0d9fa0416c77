// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/validation_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/number_text.hpp"

namespace voltlap::plant {
namespace {

std::string table_text(const StudyTable& table) {
  std::vector<std::size_t> width(table.columns.size());
  const auto measure = [&](const std::vector<std::string>& cells) {
    for (std::size_t k = 0; k < cells.size(); ++k) width[k] = std::max(width[k], cells[k].size());
  };
  measure(table.columns);
  for (const auto& row : table.rows) measure(row);
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string out = fmt::format("  {:<{}}", cells[0], width[0]);
    for (std::size_t k = 1; k < cells.size(); ++k) out += fmt::format("  {:>{}}", cells[k], width[k]);
    return out + "\n";
  };
  std::string out = fmt::format("\n{}:\n{}", table.title, line(table.columns));
  for (const auto& row : table.rows) out += line(row);
  for (const std::string& note : table.notes) out += fmt::format("  {}\n", note);
  return out;
}

}  // namespace

std::string kind_name(const FileValidation& file) {
  const char* current = file.constant_current ? "constant current" : "variable current";
  switch (file.temperature) {
    case TemperatureKind::kHeld:
      return fmt::format("{}, temperature held", current);
    case TemperatureKind::kFree:
      return fmt::format("{}, temperature free", current);
    default:
      return fmt::format("{}, temperature not recorded", current);
  }
}

std::string simulated_text(const FileValidation& v) {
  if (v.temperature != TemperatureKind::kNotRecorded) return {};
  return fmt::format("temperature simulated by the cell file's thermal model: {:.1f} degC at the start ({}), up to "
                     "{:.1f} degC",
                     v.simulated.start_c, v.simulated.start_from, v.simulated.highest_c);
}

std::string band_name(const SocBand& band) {
  if (band.high > 1.0) return fmt::format("above {:.0f} %", 100.0 * band.low);
  if (band.low < 0.0) return fmt::format("below {:.0f} %", 100.0 * band.high);
  return fmt::format("{:.0f} to {:.0f} %", 100.0 * band.low, 100.0 * band.high);
}

std::string file_text(const FileValidation& v) {
  std::string out = fmt::format(
      "{}\n  {}\n  RMS {:.1f} mV ({:.1f} mV above 10 % SOC), bias {:+.1f} mV, largest {:.0f} mV, over {} "
      "discharge stroke{}, {:.3f} Ah\n",
      v.file, kind_name(v), 1e3 * v.rms_v, 1e3 * v.rms_v_above_10_soc, shown(1e3 * v.bias_v, 1), 1e3 * v.max_error_v,
      v.strokes, v.strokes == 1 ? "" : "s", v.ah);
  std::vector<std::string> bands;
  for (const SocBand& band : v.bands) {
    if (band.error.weight_s > 0.0) bands.push_back(band_name(band) + " " + millivolts(band.error.rms_v()));
  }
  out += fmt::format("  by SOC: {}\n", fmt::join(bands, ", "));
  out += fmt::format("  SOC {:.3f} at the start, from {}; current {} (found from {})\n", v.soc_start,
                     v.soc_start_from, name_of(v.hold), v.hold_from);
  out += fmt::format("  with the capacity adjusted by {:+.2f} Ah: {}{}\n", shown(v.capacity.by_ah, 2),
                     millivolts(v.capacity.rms_v),
                     v.capacity.at_end ? " (end of the search: this recording does not tell a capacity)" : "");
  if (v.temperature_rms_c) out += fmt::format("  temperature RMS {:.2f} K\n", *v.temperature_rms_c);
  if (const std::string simulated = simulated_text(v); !simulated.empty()) out += fmt::format("  {}\n", simulated);
  if (v.voltage_lag_s > 0.0) {
    out += fmt::format(
        "  defect of the recording: its voltage trails its current by {:.2f} s (first order); with that lag in the "
        "model {:.1f} mV\n",
        v.voltage_lag_s, 1e3 * v.rms_v_with_lag);
  }
  for (const std::string& repair : v.repairs) out += fmt::format("  {}\n", repair);
  return out;
}

std::string study_text(const CellParameters& cell, const ValidationStudy& study) {
  std::string out;
  for (const StudyTable& table : study_tables(cell, study)) out += table_text(table);
  return out;
}

}  // namespace voltlap::plant
