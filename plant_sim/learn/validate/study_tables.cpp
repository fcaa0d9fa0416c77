// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/study_tables.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/number_text.hpp"
#include "learn/validate/reference_study.hpp"
#include "learn/validate/thermal_system.hpp"

namespace voltlap::plant {
namespace {

constexpr const char* kNone = "-";

/// The study's row of a parameter; none of a branch that its cells do not have.
template <class Rows>
auto row_of(const Rows& rows, std::string_view parameter) -> decltype(rows.data()) {
  const auto is_its = [&](const auto& row) { return row.parameter == parameter; };
  const auto found = std::find_if(rows.begin(), rows.end(), is_its);
  return found != rows.end() ? &*found : nullptr;
}

std::string mv_or_none(double volts) {
  return volts > 0.0 ? millivolts(volts) : std::string(kNone);
}

StudyTable kinds_table(const ValidationStudy& study) {
  using namespace voltlap::plant::study;
  StudyTable out{
      "Beside the reference study, 2016 (its own cells and tests)", {"RMS", "here", "study", "section"}, {}, {}};
  struct Row {
    const char* name;
    const KindError& here;
    double study_v, adjusted_v, by_ah;
    const char* section;
  };
  const Row rows[] = {{"constant current", study.constant_current, kRmsConstantCurrent, 0.0, 0.0, "7.1"},
                      {"variable current", study.variable_current, kRmsVariableCurrent, kRmsVariableCurrentAdjusted,
                       kVariableCurrentByAh, "7.2"},
                      {"variable current, temperature free", study.variable_temperature, kRmsVariableTemperature,
                       kRmsVariableTemperatureAdjusted, kVariableTemperatureByAh, "7.3"}};
  for (const Row& row : rows) {
    if (row.here.files == 0) continue;
    out.rows.push_back({fmt::format("{}, {} file{}", row.name, row.here.files, row.here.files == 1 ? "" : "s"),
                        millivolts(row.here.error.rms_v()), millivolts(row.study_v), row.section});
    const std::string by = row.by_ah != 0.0 ? fmt::format(" (study: by {:+.2f} Ah)", row.by_ah) : "";
    out.rows.push_back({"  capacity adjusted" + by, millivolts(row.here.adjusted.rms_v()),
                        mv_or_none(row.adjusted_v), row.section});
  }
  return out;
}

/// What the study found for a reduction, of its tests with the temperature held and free.
struct StudyReduction {
  const char* name;
  double held_v, free_v;
};
constexpr StudyReduction kStudyReductions[] = {
    {"whole model", study::kRmsVariableCurrent, study::kRmsVariableTemperature},
    {"em without current", study::kRmsWithoutCurrentInEm, 0.0},
    {"r0 without current", study::kRmsWithoutCurrentInR0, 0.0},
    {"em, r0 without current", study::kRmsVariableCurrentReduced, 0.0},
    {"em without temperature", 0.0, study::kRmsVariableTemperatureReduced}};

StudyTable reductions_table(const ValidationStudy& study) {
  StudyTable out{"Reductions: the mean over the axis in the place of the table",
                 {"RMS", "here", "study 7.2.2", "study 7.3.1"},
                 {},
                 {}};
  for (const Reduction& reduction : study.reductions) {
    const std::string name = reduction_name(reduction);
    StudyReduction beside{"", 0.0, 0.0};
    for (const StudyReduction& row : kStudyReductions) {
      if (name == row.name) beside = row;
    }
    out.rows.push_back({name, millivolts(reduction.rms_v), mv_or_none(beside.held_v), mv_or_none(beside.free_v)});
  }
  for (const StudyReduction& row : kStudyReductions) {
    const bool own = std::any_of(study.reductions.begin(), study.reductions.end(),
                                 [&](const Reduction& reduction) { return reduction_name(reduction) == row.name; });
    if (!own) out.rows.push_back({row.name, kNone, mv_or_none(row.held_v), mv_or_none(row.free_v)});
  }
  if (study.reductions.size() == 1)
    out.notes.emplace_back("the tables of this cell file depend on SOC alone: nothing to reduce");
  return out;
}

StudyTable tables_table(const CellParameters& cell, const ValidationStudy& study) {
  StudyTable out{
      "Sensitivity of the tables, Eq. 7.1 and 7.5", {"", "here %/A", "study %/A", "here %/K", "study %/K"}, {}, {}};
  const auto text = [](const std::optional<double>& value) {
    return value ? significant(*value, 3) : std::string(kNone);
  };
  for (const TableSensitivity& own : study.tables) {
    const auto* beside = row_of(study::kTableSensitivity, name_of(own.parameter));
    out.rows.push_back({name_of(own.parameter), text(own.pct_per_ampere),
                        beside != nullptr ? significant(beside->pct_per_ampere, 3) : kNone,
                        text(own.pct_per_kelvin),
                        beside != nullptr ? significant(beside->pct_per_kelvin, 3) : kNone});
  }
  if (!study.tables.front().pct_per_ampere && !study.tables.front().pct_per_kelvin)
    out.notes.emplace_back("em: this cell file has its OCV over SOC alone");
  if (cell.r0_ohm.table.empty())
    out.notes.push_back(
        fmt::format("r0 to tau{}: as the file's per_ampere and per_kelvin say, not from a table of tests",
                    cell.branch_count()));
  return out;
}

StudyTable errors_table(const ValidationStudy& study) {
  StudyTable out{
      "RMS in mV with a parameter off, capacity adjusted first; section 7.4, Table 7.3 (study in brackets)",
      {"", "+5 %", "+1 %", "nominal", "-1 %", "-5 %"},
      {},
      {}};
  for (const ErrorSensitivity& own : study.errors) {
    const auto* beside = row_of(study::kErrorSensitivity, own.parameter);
    out.rows.push_back({own.parameter});
    for (std::size_t step = 0; step < kSensitivitySteps.size(); ++step) {
      const std::string theirs = beside != nullptr ? fmt::format("{:.1f}", 1e3 * beside->rms_v[step]) : kNone;
      out.rows.back().push_back(fmt::format("{:.1f} ({})", 1e3 * own.rms_v[step], theirs));
    }
  }
  return out;
}

std::string air_text(const ThermalValidation::File& file) {
  switch (file.air) {
    case AirFrom::kLog:
      return "air as recorded";
    case AirFrom::kStartAfterRest:
      return fmt::format("air: {:.1f} +- {:.1f} degC, from its start after a rest", file.air_c, file.air_ci95_k);
    default:
      return fmt::format(
          "air: {:.1f} +- {:.1f} degC, fitted: neither recorded nor told by a rest at the start (assumed within {:.0f} "
          "K of the start)",
          file.air_c, file.air_ci95_k, 2.0 * kFreeAir_k);
  }
}

std::string kelvin_or_none(const std::optional<double>& rms) {
  return rms ? fmt::format("{:.2f} K", *rms) : std::string(kNone);
}

/// "54.3 +- 1.2"; the interval in words where there is none.
std::string plus_minus(double value, double half_width) {
  return significant(value, 4) + (std::isfinite(half_width) ? " +- " + significant(half_width, 2)
                                                            : fmt::format(" ({})", kNotSettled));
}

/// Of one number: what is told of it.
std::string interval_text(double value, double half_width, bool told, const char* unit) {
  return fmt::format("{} {}{}", plus_minus(value, half_width), unit, told ? "" : " (not told)");
}

/// The heat capacity and what goes with it: one line for each two numbers that the data do not tell apart.
std::string class_text(const ThermalClass& one) {
  const bool entropy = one.other_unit == "V/K";  // in steps of a size that cells have
  const double step = entropy ? 1e-4 : 1.0;
  const std::string at = entropy ? std::string("without reversible heat")
                                 : fmt::format("with {} {} {}", one.other, significant(one.at, 3), one.other_unit);
  const double slope = step * one.slope;
  return fmt::format("not told apart: {} and {}. Together: {} {} {} {}, and {}{} {} for each {}", one.number, one.other,
                     one.number, plus_minus(one.value, one.ci95), one.unit, at, slope > 0.0 ? "+" : "",
                     significant(slope, 3), one.unit,
                     entropy ? "+0.1 mV/K" : fmt::format("{} more", one.other_unit));
}

std::vector<std::string> thermal_notes(const CellParameters& cell, const ThermalValidation& thermal) {
  const ThermalModel& m = thermal.fitted;
  std::vector<std::string> out{fmt::format(
      "of the cell (95 %): heat capacity {}, cooling {}, dOCV/dT {}, {}",
      interval_text(m.capacity_j_per_k, m.capacity_j_per_k * m.capacity_ci95, m.capacity_told, "J/K"),
      interval_text(m.conductance_w_per_k, m.conductance_w_per_k * m.conductance_ci95, m.conductance_told, "W/K"),
      interval_text(1e3 * m.entropy_v_per_k, 1e3 * m.entropy_ci95_v_per_k, m.entropy_told, "mV/K"),
      m.surface_lag_s > 0.0
          ? fmt::format("surface {} s behind", plus_minus(m.surface_lag_s, m.surface_lag_ci95_s))
          : fmt::format("no lag of the surface shows (at most {} s)", significant(m.surface_lag_ci95_s, 2)))};
  for (const ThermalClass& one : m.classes) out.push_back(class_text(one));
  out.push_back(fmt::format(
      "assumed: dOCV/dT 0 +- {:.1f} mV/K (1 sigma) beforehand, one number for every SOC; per kg and m2 with the file's "
      "{} kg and {} m2",
      1e3 * kEntropySd_v_per_k, significant(cell.mass_kg, 3), significant(cell.surface_area_m2, 3)));
  const char* how =
      thermal.files.size() > 1 ? "by a fit of the other files" : "in its second half by a fit of its first";
  for (const ThermalValidation::File& file : thermal.files) {
    out.push_back(fmt::format("{}: RMS {} as the cell file says, {} fitted, {}; {}", file.file,
                              kelvin_or_none(file.rms_as_given_c), kelvin_or_none(file.rms_fitted_c),
                              file.rms_held_out_c ? fmt::format("{:.2f} K {}", *file.rms_held_out_c, how)
                                                  : "not held out: the rest tells too little",
                              air_text(file)));
  }
  out.emplace_back("for the cell file:");
  for (const std::string& line : cell_file_lines(cell, m)) out.push_back("  " + line);
  return out;
}

StudyTable thermal_table(const CellParameters& cell, const ThermalValidation& thermal) {
  const ThermalModel& m = thermal.fitted;
  StudyTable out{"Thermal model, section 7.5, fitted to the recorded temperatures",
                 {"", "here", "95 %", "cell file", "study"},
                 {},
                 thermal_notes(cell, thermal)};
  const double per_kg = m.capacity_j_per_k / cell.mass_kg, per_m2 = m.conductance_w_per_k / cell.surface_area_m2;
  const auto row = [&](const char* name, double value, double half_width, bool told, double given,
                       const std::string& study, int digits) {
    out.rows.push_back({name, fmt::format("{:.{}f}", value, digits),
                        std::isfinite(half_width)
                            ? fmt::format("+- {:.{}f}{}", half_width, digits, told ? "" : ", not told")
                            : kNotSettled,
                        fmt::format("{:.{}f}", given, digits), study});
  };
  row("heat_capacity_j_per_kg_k", per_kg, per_kg * m.capacity_ci95, m.capacity_told, cell.heat_capacity_j_per_kg_k,
      fmt::format("{:.0f}", study::kHeatCapacity_j_per_kg_k), 0);
  row("convection_w_per_m2_k", per_m2, per_m2 * m.conductance_ci95, m.conductance_told, cell.convection_w_per_m2_k,
      fmt::format("{:.2f}", study::kConvection_w_per_m2_k), 2);
  row("surface_lag_s", m.surface_lag_s, m.surface_lag_ci95_s, true, cell.surface_lag_s, kNone, 1);
  row("effects.entropy_v_per_k", m.entropy_v_per_k, m.entropy_ci95_v_per_k, m.entropy_told,
      cell.effects.entropy_v_per_k, kNone, 6);
  return out;
}

StudyTable pack_table(const PackComparison& pack, const std::string& file) {
  constexpr double kRounding = 1e9;  // beyond it sigma is that of the computer's numbers
  const auto snr = [](double value) {
    return value < kRounding ? significant(value, 3) : std::string("no noise");
  };
  const PackDifference &equal = pack.equal, &differing = pack.differing;
  StudyTable out{fmt::format("One cell for {}, through the current of {}; Appendix C (24 cells, an endurance)",
                             pack.cells, file),
                 {"difference of pack and one cell", "equal cells", "study", "differing"},
                 {},
                 {}};
  const auto mv = [](double volts) { return significant(1e3 * volts, 2) + " mV"; };
  const auto percent = [](double soc) { return significant(100.0 * soc, 2) + " %"; };
  out.rows = {
      {"pack voltage, mean", mv(equal.voltage_mean_v), mv(study::kPackMean_v), mv(differing.voltage_mean_v)},
      {"pack voltage, largest", mv(equal.voltage_max_v), kNone, mv(differing.voltage_max_v)},
      {"signal to noise (range over sigma)", snr(equal.snr), significant(study::kPackSnr, 3), snr(differing.snr)},
      {"SOC, largest", percent(equal.soc_max), percent(study::kPackSocMax), percent(differing.soc_max)},
      {"weakest cell below the mean", millivolts(equal.weakest_cell_v), kNone,
       millivolts(differing.weakest_cell_v)}};
  const CellSpread spread;
  out.notes.push_back(
      fmt::format("differing: sigma {:g} % of capacity, {:g} % of resistance, {:g} % of SOC, seed {}",
                  100.0 * spread.capacity, 100.0 * spread.resistance, 100.0 * spread.initial_soc, spread.seed));
  return out;
}

}  // namespace

std::string millivolts(double volts) {
  return fmt::format("{:.1f} mV", 1e3 * volts);
}

std::string reduction_name(const Reduction& reduction) {
  if (reduction.parameters.empty()) return "whole model";
  std::vector<std::string> names;
  for (const TableParameter parameter : reduction.parameters) names.emplace_back(name_of(parameter));
  return fmt::format("{} without {}", fmt::join(names, ", "),
                     reduction.axis == TableAxis::kCurrent ? "current" : "temperature");
}

std::vector<StudyTable> study_tables(const CellParameters& cell, const ValidationStudy& study) {
  std::vector<StudyTable> out{kinds_table(study)};
  if (!study.reductions.empty()) out.push_back(reductions_table(study));
  if (!study.tables.empty()) out.push_back(tables_table(cell, study));
  if (!study.errors.empty()) out.push_back(errors_table(study));
  if (study.thermal) out.push_back(thermal_table(cell, *study.thermal));
  if (study.pack) out.push_back(pack_table(*study.pack, study.files.front().file));
  return out;
}

}  // namespace voltlap::plant
