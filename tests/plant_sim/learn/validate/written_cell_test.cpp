// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/written_cell.hpp"

#include <algorithm>
#include <cmath>

#include "learn/identify/result/cell_file.hpp"
#include "learn/identify/result/cell_parameters.hpp"
#include "plant_sim/core/scratch.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

const DataFolder& data() {
  static const DataFolder folder{VOLTLAP_DATA_FOLDER};
  return folder;
}

/// Identified once.
const CellIdentification& identified() {
  static const CellIdentification once = [] {
    KnownCell cell;
    cell.noise_v = 3e-4;
    IdentifyOptions options;
    options.branches = 2;
    return identify_cell({cell.record(cell.pulse_plan(33.0, 500, 0.0))}, {25.0}, options);
  }();
  return once;
}

std::string toml() {
  std::vector<std::string> notes;
  const CellBody body = cell_body({}, identified().reference_point().result.capacity,
                                  [](const std::string& name) { return load_cell(data(), name, "test"); });
  return cell_toml(cell_parameters(identified(), body, "known", notes), body, identified());
}

}  // namespace

TEST_GROUP(WrittenCell) {
  CellIdentification found = identified();
  RecordingResult& recording() { return found.reference_point().result.files.front(); }
};

TEST(WrittenCell, ItsErrorsStandInThePlaceOfTheFits) {
  const double fit_v = recording().rms_v;
  take_errors_of_file(read_back(toml(), data()), {identified()}, found);
  CHECK(recording().read_back.has_value());
  DOUBLES_EQUAL(fit_v, recording().read_back->fit_rms_v, 0.0);
  CHECK(recording().rms_v > 3e-4 && recording().rms_v < 5e-3);
  const auto& trace = recording().trace;
  const double square = trace.weight_s.dot(trace.error_v.cwiseAbs2()) / trace.weight_s.sum();
  DOUBLES_EQUAL(recording().rms_v, std::sqrt(square), 1e-9);
  DOUBLES_EQUAL(recording().read_back->used_rms_v, found.reference_point().result.rms_v, 1e-9);
  require_file_follows(found);
}

TEST(WrittenCell, AFileThatTheProductRefusesIsRefused) {
  std::string text = toml();
  const std::size_t at = text.find("voltage_max_v = ");
  text.replace(at, text.find('\n', at) - at, "voltage_max_v = 0.5");
  STRCMP_CONTAINS("voltage_min_v", complaint([&] { (void)read_back(text, data()); }).c_str());
}

TEST(WrittenCell, AnOcvOfFourteenVoltsIsRefusedWithTheCountThatWasForgotten) {
  CellParameters file = read_back(toml(), data());
  require_possible_cell(file, found, 1);
  for (double& v : file.ocv_v) v *= 4.0;
  recording().trace.voltage_v *= 4.0;
  const std::string said = complaint([&] { require_possible_cell(file, found, 1); });
  STRCMP_CONTAINS("known cell", said.c_str());
  STRCMP_CONTAINS("--cells-in-series 4", said.c_str());
  STRCMP_CONTAINS("Nothing was written", said.c_str());
}

TEST(WrittenCell, ResistancesAndTimeConstantsOfNoCellAreRefused) {
  const auto said_with = [&](const auto& change) {
    CellParameters file = read_back(toml(), data());
    change(file);
    return complaint([&] { require_possible_cell(file, found, 1); });
  };
  const std::string none = said_with([](CellParameters& file) {
    std::fill(file.r0_ohm.value.begin(), file.r0_ohm.value.end(), 1e-7);
  });
  STRCMP_CONTAINS("a resistance R0", none.c_str());
  const std::string slow = said_with([](CellParameters& file) { file.branches[1].tau_s.value[3] = 3e5; });
  STRCMP_CONTAINS("a time constant of 3e+05 s", slow.c_str());
}

TEST(WrittenCell, AFileThatDoesNotFollowWhatWasFittedIsRefused) {
  CellParameters file = read_back(toml(), data());
  for (double& r : file.r0_ohm.value) r *= 3.0;
  take_errors_of_file(file, {identified()}, found);
  STRCMP_CONTAINS("by the cell file read back", complaint([&] { require_file_follows(found); }).c_str());
  for (double& v : file.ocv_v) v += 0.3;
  found = identified();
  take_errors_of_file(file, {identified()}, found);
  STRCMP_CONTAINS("misses half of its rows", complaint([&] { require_file_follows(found); }).c_str());
}

TEST(WrittenCell, OfPulsesWithoutAThermometerSaysWhatWasFitted) {
  // 3C, by a body that warms by some ten kelvin: the file warms as the fit did.
  KnownCell cell;
  cell.noise_v = 3e-4;
  IdentifyOptions options;
  options.branches = 2;
  const auto shipped = [](const std::string& name) { return load_cell(data(), name, "test"); };
  options.thermal = [&](double capacity_ah) {
    CellParameters parameters;
    cell_body({}, {.ah = capacity_ah}, shipped).write_into(parameters);
    return thermal_of(parameters);
  };
  CellIdentification hot = identify_cell({cell.record(cell.pulse_plan(90.0, 500, 0.0))}, {25.0}, options);
  const CellIdentification as_fitted = hot;
  const RecordingResult& file = hot.reference_point().result.files.front();
  CHECK(file.warmest_c > 30.0);
  std::vector<std::string> notes;
  const CellBody body = cell_body({}, hot.reference_point().result.capacity, shipped);
  take_errors_of_file(read_back(cell_toml(cell_parameters(hot, body, "known", notes), body, hot), data()), {as_fitted},
                      hot);
  CHECK(file.read_back->used_rms_v < 1.5 * file.read_back->fit_used_rms_v + 5e-4);
}

TEST(WrittenCell, AStateOfChargeThatIsNoneIsRefused) {
  require_possible_soc(found);
  const auto refused = [&](double low, double high, double rms_v) {
    recording().soc_low = low;
    recording().soc_high = high;
    recording().rms_pulses_v = rms_v;
    return complaint([&] { require_possible_soc(found); });
  };
  STRCMP_CONTAINS("a state of charge from -1.31 to 1.02", refused(-1.308, 1.017, 2e-3).c_str());
  STRCMP_CONTAINS("a state of charge from 0.00 to 1.30", refused(0.0, 1.3, 2e-3).c_str());
  STRCMP_CONTAINS("would miss it by 60 mV", refused(-0.1, 1.0, 0.06).c_str());
  STRCMP_EQUAL("no error", refused(-0.1, 1.0, 0.03).c_str());  // the cold, an aged cell, another counter
  STRCMP_EQUAL("no error", refused(-0.04, 1.04, 0.06).c_str());
}
