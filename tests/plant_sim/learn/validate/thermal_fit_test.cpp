// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/thermal_fit.hpp"

#include <cmath>

#include "plant_sim/core/scratch.hpp"
#include "straight_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

constexpr double kCapacity = 500.0, kConductance = 0.5;  // J/K, W/K: a thousand seconds

/// Heats with `heat_w` for half the time and cools for the other, integrated by Euler in steps of 10 ms; what is read
/// follows by `lag_s`.
ThermalRecording heated(double heat_w, double ambient_c, double step_k = 0.0, double start_c = 25.0,
                        double lag_s = 0.0) {
  ThermalRecording out{"heated.csv", {}, {}, {}, {}, false};
  double t = start_c, read = start_c;
  constexpr int kRows = 1200;
  constexpr double kRow = 3.0, kFine = 0.01;
  for (int row = 0; row < kRows; ++row) {
    const double heat = row < kRows / 2 ? heat_w : 0.0;
    if (row > 0) {
      for (double s = 0.0; s < kRow - 0.5 * kFine; s += kFine) {
        t += kFine * (heat - kConductance * (t - ambient_c)) / kCapacity;
        if (lag_s > 0.0) read += kFine / lag_s * (t - read);
      }
    }
    if (lag_s <= 0.0) read = t;
    out.dt_s.push_back(row > 0 ? kRow : 0.0);
    out.heat_w.push_back(heat);
    out.temperature_c.push_back(step_k > 0.0 ? step_k * std::round(read / step_k) : read);
  }
  out.ambient_c.assign(out.dt_s.size(), ambient_c);
  return out;
}

}  // namespace

TEST_GROUP(ThermalFit) {
  CellParameters cell = StraightCell::cell();
};

TEST(ThermalFit, HeatCapacityAndCoolingComeBack) {
  const ThermalModel model = fit_thermal({heated(8.0, 25.0)});
  DOUBLES_EQUAL(kCapacity, model.capacity_j_per_k, 0.1);
  DOUBLES_EQUAL(kConductance, model.conductance_w_per_k, 1e-4);
}

TEST(ThermalFit, TheLagOfTheSurfaceComesBackAndIsHeldOutToo) {
  const ThermalRecording recording = heated(8.0, 22.0, 0.0, 25.0, 45.0);
  const ThermalModel model = fit_thermal({recording});
  DOUBLES_EQUAL(45.0, model.surface_lag_s, 0.2);
  DOUBLES_EQUAL(kCapacity, model.capacity_j_per_k, 0.2);
  DOUBLES_EQUAL(kConductance, model.conductance_w_per_k, 2e-4);
  DOUBLES_EQUAL(0.0, thermal_rms_c(model, recording), 2e-3);
  CHECK(thermal_rms_c({kCapacity, kConductance, 0.0, 0.0}, recording) > 0.2);
}

TEST(ThermalFit, WholeDegreesOfACellWithoutALagTellNone) {
  const ThermalModel model = fit_thermal({heated(8.0, 25.0, 1.0)});
  DOUBLES_EQUAL(0.0, model.surface_lag_s, 0.0);
  const ThermalModel exact = fit_thermal({heated(8.0, 25.0)});
  DOUBLES_EQUAL(0.0, exact.surface_lag_s, 0.2);
}

TEST(ThermalFit, AmbientThatWasNotRecordedIsThatOfTheStart) {
  CellLog log = StraightCell::record(StraightCell::half());
  log.temperature_c.assign(log.rows(), 21.0);
  RunOptions options;
  options.capacity_ah = cell.capacity_ah;
  const MeasuredRun run = make_run(log, options);
  const RecordedTemperature temperature(log, 25.0);
  const ThermalRecording recording =
      thermal_recording("file", run, respond(CellModel(cell), run, temperature), temperature);
  CHECK(recording.ambient_assumed);
  LONGS_EQUAL(log.rows(), recording.ambient_c.size());
  DOUBLES_EQUAL(21.0, recording.ambient_c[500], 0.0);
}

TEST(ThermalFit, WholeDegreesAreCoveredByTheInterval) {
  const ThermalModel model = fit_thermal({heated(8.0, 25.0, 1.0)});
  CHECK(std::abs(std::log(model.capacity_j_per_k / kCapacity)) < model.capacity_ci95);
  CHECK(std::abs(std::log(model.conductance_w_per_k / kConductance)) < model.conductance_ci95);
  CHECK(model.capacity_ci95 > 0.002 && model.capacity_ci95 < 0.2);
}

TEST(ThermalFit, HolesInTheTemperatureAreLeftOut) {
  ThermalRecording recording = heated(8.0, 25.0);
  for (std::size_t row = 100; row < 300; ++row) recording.temperature_c[row] = std::nan("");
  DOUBLES_EQUAL(kCapacity, fit_thermal({recording}).capacity_j_per_k, 0.1);
}

TEST(ThermalFit, AfterAGapItGoesOnFromWhatIsRecordedThere) {
  ThermalRecording recording = heated(8.0, 25.0);
  recording.dt_s[700] = 0.0;
  for (std::size_t row = 700; row < recording.temperature_c.size(); ++row)
    recording.temperature_c[row] = 25.0 + (40.0 - 25.0) * std::exp(-3.0 * static_cast<double>(row - 700) / 1000.0);
  DOUBLES_EQUAL(kCapacity, fit_thermal({recording}).capacity_j_per_k, 0.2);
  DOUBLES_EQUAL(0.0, thermal_rms_c({kCapacity, kConductance, 0.0, 0.0}, recording), 0.01);
}

TEST(ThermalFit, TemperatureThatStaysIsRefused) {
  STRCMP_CONTAINS("temperatures within", complaint([] { (void)fit_thermal({heated(0.05, 25.0)}); }).c_str());
}

TEST(ThermalFit, CellThatCoolsUnderLoadIsRefused) {
  ThermalRecording recording = heated(8.0, 25.0);
  for (double& t : recording.temperature_c) t = 50.0 - t;
  STRCMP_CONTAINS("cools under load", complaint([&] { (void)fit_thermal({recording}); }).c_str());
}

TEST(ThermalFit, EachRecordingIsPredictedByTheOthers) {
  const ThermalValidation found =
      validate_thermal(cell, {heated(8.0, 25.0), heated(3.0, 20.0), heated(12.0, 30.0)});
  LONGS_EQUAL(3, found.files.size());
  for (const ThermalValidation::File& file : found.files) DOUBLES_EQUAL(0.0, *file.rms_held_out_c, 0.01);
  // As the file says (500 J/K and 0.5 W/K, by chance the truth).
  DOUBLES_EQUAL(0.0, found.files[0].rms_as_given_c, 0.01);
}

TEST(ThermalFit, SecondHalfOfASingleRecordingIsPredictedByItsFirst) {
  cell.convection_w_per_m2_k = 0.0;
  const ThermalValidation found = validate_thermal(cell, {heated(8.0, 25.0)});
  DOUBLES_EQUAL(0.0, *found.files[0].rms_held_out_c, 0.05);
  CHECK(found.files[0].rms_as_given_c > 5.0);
}
