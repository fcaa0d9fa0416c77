// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/validation_study.hpp"

#include "plant_sim/core/scratch.hpp"
#include "learn/validate/validation_json.hpp"
#include "learn/validate/validation_text.hpp"
#include "straight_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(ValidationStudy) {
  CellParameters cell = StraightCell::cell();
  std::vector<CellLog> logs{StraightCell::record(StraightCell::half())};
  StudyOptions options;
  std::string text() {
    return study_text(cell, study_validation(cell, logs, options));
  }

  static std::vector<double> variable() {
    std::vector<double> currents;
    for (int k = 0; k < 900; ++k) currents.push_back((k / 20) % 2 == 0 ? 35.0 : 10.0);
    return currents;
  }
};

TEST(ValidationStudy, ConstantCurrentStandsBesideSection71) {
  STRCMP_CONTAINS("constant current", text().c_str());
  STRCMP_CONTAINS("15.0 mV      7.1", text().c_str());
  CHECK(text().find("      7.2") == std::string::npos);
}

TEST(ValidationStudy, VariableCurrentStandsBesideSection72) {
  logs = {StraightCell::record(variable())};
  STRCMP_CONTAINS("32.8 mV      7.2", text().c_str());
  STRCMP_CONTAINS("(study: by -0.72 Ah)", text().c_str());
}

TEST(ValidationStudy, TemperatureThatIsFreeStandsBesideSection73) {
  logs = {StraightCell::record(variable())};
  for (std::size_t row = 0; row < logs[0].rows(); ++row)
    logs[0].temperature_c.push_back(25.0 + 10.0 * static_cast<double>(row) / static_cast<double>(logs[0].rows()));
  STRCMP_CONTAINS("64.6 mV      7.3", text().c_str());
  STRCMP_CONTAINS("(study: by +1.20 Ah)", text().c_str());
}

TEST(ValidationStudy, TablesOfTheStudyStandBesideTheOwn) {
  options.sensitivity = options.reductions = true;
  options.pack_cells = 24;
  const std::string all = text();
  STRCMP_CONTAINS("-0.034", all.c_str());      // Table 7.1, R0
  STRCMP_CONTAINS("(192.8)", all.c_str());     // Table 7.3, Em + 5 %
  STRCMP_CONTAINS("-0.27 mV", all.c_str());  // Appendix C
  STRCMP_CONTAINS("nothing to reduce", all.c_str());
}

TEST(ValidationStudy, FilesOfAKindCountByTheirTime) {
  logs.push_back(StraightCell::record(StraightCell::half()));
  for (std::size_t row = StraightCell::kRest; row < logs[1].rows(); ++row) logs[1].voltage_v[row] -= 0.03;
  const ValidationStudy study = study_validation(cell, logs, options);
  LONGS_EQUAL(2, study.constant_current.files);
  DOUBLES_EQUAL(0.03 / std::sqrt(2.0), study.constant_current.error.rms_v(), 1e-4);
}

TEST(ValidationStudy, ThermalFitNeedsATemperature) {
  options.thermal = true;
  STRCMP_CONTAINS("no recording with a temperature", complaint([&] { (void)text(); }).c_str());
}

TEST(ValidationStudy, ThermalFitFindsTheCellThatMadeTheTemperature) {
  options.thermal = true;
  const std::vector<double> rest(1800, 0.0);
  std::vector<double> plan = StraightCell::half();
  plan.insert(plan.end(), rest.begin(), rest.end());
  logs = {StraightCell::record(plan)};
  RunOptions run;
  run.capacity_ah = cell.capacity_ah;
  const CellResponse truth = respond(CellModel(cell), make_run(logs[0], run), RecordedTemperature(logs[0], 25.0));
  logs[0].temperature_c.assign(truth.temperature.begin(), truth.temperature.end());
  logs[0].ambient_c.assign(logs[0].rows(), 25.0);
  cell.heat_capacity_j_per_kg_k = 700.0;  // the file is wrong
  const ValidationStudy study = study_validation(cell, logs, options);
  DOUBLES_EQUAL(500.0, study.thermal->fitted.capacity_j_per_k, 1.0);
  DOUBLES_EQUAL(0.5, study.thermal->fitted.conductance_w_per_k, 1e-3);
}

/// The cell of the file, but with an entropy, discharged and charged in turn.
CellLog discharged_and_charged(CellParameters truth, double entropy_v_per_k) {
  std::vector<double> plan;
  for (int stroke = 0; stroke < 6; ++stroke) {
    plan.insert(plan.end(), 900, stroke % 2 == 0 ? 20.0 : -20.0);
    plan.insert(plan.end(), 300, 0.0);
  }
  CellLog log = StraightCell::record(plan);
  truth.effects.entropy_v_per_k = entropy_v_per_k;
  RunOptions run;
  run.capacity_ah = truth.capacity_ah;
  const CellResponse response = respond(CellModel(truth), make_run(log, run), RecordedTemperature(log, 25.0));
  log.temperature_c.assign(response.temperature.begin(), response.temperature.end());
  log.ambient_c.assign(log.rows(), 25.0);
  return log;
}

TEST(ValidationStudy, ThermalFitDoesNotTakeReversibleHeatForHeatCapacity) {
  options.thermal = true;
  logs = {discharged_and_charged(cell, 4e-4)};
  const ValidationStudy study = study_validation(cell, logs, options);
  DOUBLES_EQUAL(500.0, study.thermal->fitted.capacity_j_per_k, 5.0);
  DOUBLES_EQUAL(0.5, study.thermal->fitted.conductance_w_per_k, 5e-3);
  DOUBLES_EQUAL(4e-4, study.thermal->fitted.entropy_v_per_k, 4e-6);
}

TEST(ValidationStudy, LinesForTheCellFileReproduceWhatWasPrinted) {
  options.thermal = true;
  logs = {discharged_and_charged(cell, 4e-4)};
  cell.heat_capacity_j_per_kg_k = 700.0;
  const ThermalValidation first = *study_validation(cell, logs, options).thermal;
  CHECK(*first.files[0].rms_as_given_c > 0.3);
  cell.heat_capacity_j_per_kg_k = first.fitted.capacity_j_per_k / cell.mass_kg;
  cell.convection_w_per_m2_k = first.fitted.conductance_w_per_k / cell.surface_area_m2;
  cell.surface_lag_s = first.fitted.surface_lag_s;
  cell.effects.entropy_v_per_k = first.fitted.entropy_v_per_k;
  const ThermalValidation again = *study_validation(cell, logs, options).thermal;
  DOUBLES_EQUAL(*first.files[0].rms_fitted_c, *again.files[0].rms_as_given_c, 1e-3);
  DOUBLES_EQUAL(first.fitted.capacity_j_per_k, again.fitted.capacity_j_per_k, 0.5);
}

TEST(ValidationStudy, TemperatureThatWasNotRecordedIsSaidToBeSimulated) {
  const FileValidation file = study_validation(cell, logs, options).files[0];
  const std::string said = file_text(file);
  STRCMP_CONTAINS("temperature simulated by the cell file's thermal model: 25.0 degC at the start", said.c_str());
  STRCMP_CONTAINS("at the start (assumed), up to 29.7 degC", said.c_str());
  CHECK(said.find("0.00 K") == std::string::npos);
  options.validation.temperature_c = 10.0;
  options.validation.temperature_told = true;
  STRCMP_CONTAINS("10.0 degC at the start (--temperature)",
                  file_text(study_validation(cell, logs, options).files[0]).c_str());
}

TEST(ValidationStudy, TemperatureInRowsWithoutAVoltageHasAnRms) {
  // A voltage in every other row, the temperature in the others, 3 K above what the cell's heat makes of it.
  for (std::size_t row = 0; row < logs[0].rows(); ++row) {
    logs[0].temperature_c.push_back(row % 2 == 0 ? 25.0 + (row > 200 ? 3.0 : 0.0) : std::nan(""));
    if (row % 2 == 0 && row > 0) logs[0].voltage_v[row] = std::nan("");
  }
  const FileValidation file = study_validation(cell, logs, options).files[0];
  CHECK(file.temperature_rms_c.has_value());
  CHECK(*file.temperature_rms_c > 0.5);
}

TEST(ValidationStudy, JsonNamesWhatATeamReads) {
  options.sensitivity = true;
  const std::string json = validation_json(cell, study_validation(cell, logs, options), "test");
  for (const char* key : {"\"rms_v\"", "\"rms_v_above_10_soc\"", "\"bias_v\"", "\"max_error_v\"",
                          "\"temperature_rms_c\"", "\"ah\"", "\"soc_start\"", "\"soc_start_from\"",
                          "\"capacity_adjustment_ah\"", "\"pct_per_ampere\"", "\"plus_5_pct\"",
                          "\"temperature_start_from\"", "\"temperature_model_highest_c\""})
    STRCMP_CONTAINS(key, json.c_str());
}
