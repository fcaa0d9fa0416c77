// SPDX-License-Identifier: Apache-2.0
#include "apps/soc_test_command.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/firmware_config.hpp"
#include "apps/flag_checks.hpp"
#include "apps/other_programs.hpp"
#include "apps/run_recorder.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"

namespace voltlap::plant {
namespace {

constexpr const char* kTracks[] = {"michigan_2015", "michigan_2014"};
constexpr int kShortLaps = 6;  // 16 % of the charge, of which 6 are judged

/// A car that the BMS does not know of.
struct Condition {
  const char* name;
  std::vector<std::string> settings;
};

std::vector<Condition> conditions(bool all) {
  // The car of the reference study ends at 50 degC: a hot day goes on to the BMS's own bound.
  const std::string hot = "assertions.battery_temperature_max_c=60";
  std::vector<Condition> out{{"the cells as believed", {}},
                             {"one weak cell (capacity -15 %, resistance +40 %)",
                              {"battery.cells.7.capacity_scale=0.85", "battery.cells.7.resistance_scale=1.4"}}};
  if (!all) return out;
  out.push_back({"5 degC", {"environment.ambient_c=5", "battery.initial_temperature_c=5"}});
  out.push_back({"40 degC", {"environment.ambient_c=40", "battery.initial_temperature_c=40", hot}});
  return out;
}

/// Slope of the OCV where it is flattest over a twentieth of the charge [V over the charge].
double flattest_slope_v(const CellParameters& cell) {
  constexpr double kWidth = 0.05;
  constexpr int kPlaces = 90;
  const CellTables tables(cell);
  const double c = cell.reference_temperature_c;
  double least = 1e300;
  for (int k = 0; k <= kPlaces; ++k) {
    const double low = 0.05 + (0.9 - kWidth) * k / kPlaces;
    least = std::min(least, (tables.ocv_v(low + kWidth, c) - tables.ocv_v(low, c)) / kWidth);
  }
  return std::max(least, 1e-3);
}

/// What so many volts are worth where the OCV is flattest.
SocMark voltage_mark(double volts, double flattest_v) {
  return {std::max(kMarkOne.rms, 100.0 * volts / flattest_v), std::max(kMarkOne.largest, 100.0 * volts / flattest_v)};
}

std::vector<SocJudgedCase> single_errors(double flattest_v) {
  constexpr double kHalfVoltage_v = 3.8;
  return {{{"nothing wrong", {}}, kMarkOne},
          {{"start -20 points", {.start_points = -20, .restarted = true}}, kMarkOne},
          {{"current offset +1 % of the range", {.current_offset = 0.01}}, kMarkOne},
          {{"current offset -1 % of the range", {.current_offset = -0.01}}, kMarkOne},
          {{"current gain +2 %", {.current_gain = 1.02}}, kMarkOne},
          {{"current gain -2 %", {.current_gain = 0.98}}, kMarkOne},
          {{"resistance +30 %", {.resistance = 1.3}}, kMarkOne},
          {{"resistance -30 %", {.resistance = 0.7}}, kMarkOne},
          {{"capacity +10 %", {.capacity = 1.1}}, kMarkOne},
          {{"capacity -10 %", {.capacity = 0.9}}, kMarkOne},
          {{"noise", {.noise = true}}, kMarkOne},
          {{"quantisation", {.quantisation = true}}, kMarkOne},
          {{"cell voltage +5 mV", {.voltage_offset_v = 0.005}}, voltage_mark(0.005, flattest_v)},
          {{"cell voltage +0.2 %", {.voltage_gain = 1.002}}, voltage_mark(0.002 * kHalfVoltage_v, flattest_v)}};
}

/// All but those of the voltage; `sensor` and `belief`: the sign of the errors of current, and of resistance and
/// capacity.
SocJudgedCase together(double sensor, double belief) {
  return {{fmt::format("all: current {:+.0f}, belief {:+.0f}", sensor, belief),
           {.start_points = -20,
            .restarted = true,
            .current_offset = 0.01 * sensor,
            .current_gain = 1.0 + 0.02 * sensor,
            .resistance = 1.0 + 0.3 * belief,
            .capacity = 1.0 + 0.1 * belief,
            .noise = true,
            .quantisation = true}},
          kMarkTogether};
}

std::vector<SocJudgedCase> cases_of(bool every_one, double flattest_v) {
  std::vector<SocJudgedCase> out = single_errors(flattest_v);
  if (!every_one) out.resize(1);
  for (const double sensor : {1.0, -1.0}) {
    for (const double belief : {1.0, -1.0}) out.push_back(together(sensor, belief));
  }
  return out;
}

/// Marks of a drive in which nothing was judged would be neither met nor missed.
void refuse_unjudged(const std::string& vehicle, const SocDriveResult& drive, bool short_form) {
  if (drive.trial.judged_s > 0.0) return;
  const EnduranceResult& driven = drive.trial.drive;
  throw InputError(fmt::format("vehicle {}, {}, {}", vehicle, drive.course, drive.car),
                   driven.finished ? "less than a tenth of the charge is drawn"
                                   : "the drive ends before a tenth of the charge is drawn: " + driven.failure_cause,
                   "a drive in which more is: only what comes after it is judged",
                   driven.finished && short_form ? "Leave --short away, or set a smaller pack"
                                                 : "Try the car with ./voltlap endurance first");
}

}  // namespace

SocTestCommand::SocTestCommand(CLI::App& app) : command_(app.add_subcommand("soc-test", what_it_does("soc-test"))) {
  car_.add_vehicle(*command_);
  command_->add_flag("--short", short_, "One course, six laps, two cars: seconds instead of minutes");
  CLI::Option* data = recordings_.add(*command_, "--data")->type_name("FILE");
  CLI::Option* cell = command_->add_option("--cell", cell_, "Their cell file: name or path")->needs(data);
  command_
      ->add_option("--temperature", temperature_c_,
                   "degC of recordings that have no temperature column; default: the cell file's own")
      ->check(number_between(-40.0, 80.0, "In degC; correct the number, or leave the flag out"))
      ->needs(data);
  data->needs(cell);
  for (const char* how : {"--map", "--dbc", "--write-map", "--cells-in-series", "--cells-in-parallel"})
    command_->get_option(how)->needs(data);
  command_->add_flag("--only-data", only_recordings_, "The recordings alone, no drive")->needs(data);
  add_output_file(*command_, "--json", json_, "Write every row as JSON");
  command_->footer(
      "Each endurance is driven once, by a BMS that is told the truth; others listen on the same bus, each with an\n"
      "error of its own, by the filter (ekf) and by counting (coulomb). A start that is off is a restart after 30 s\n"
      "of driving from a record that is. An offset of the current comes with the drive: one that is there at rest is\n"
      "learned. Recordings begin at a rest, or under load from one, and are judged by the charge that they counted\n"
      "from the open-circuit voltage at their begin.\n"
      "Example: voltlap soc-test --short --json soc.json\n"
      "Exit code: 0 all was measured, marks met or not, 2 usage or input, 130 interrupted.");
}

std::vector<SocDriveResult> SocTestCommand::drive_all(const DataFolder& data, ProgressLine& progress) const {
  std::vector<SocDriveResult> out;
  const std::size_t tracks = short_ ? 1 : std::size(kTracks);
  const std::vector<Condition> cars = conditions(!short_);
  for (std::size_t t = 0; t < tracks; ++t) {
    for (const Condition& condition : cars) {
      CarOptions car = car_;
      car.settings.insert(car.settings.end(), condition.settings.begin(), condition.settings.end());
      car.settings.emplace_back("bms.soc_method=ekf");
      EnduranceOptions options;
      const LoadedVehicle loaded = car.load_car(data);
      options.vehicle = loaded.parameters;
      options.track = load_track(data.path(fmt::format("tracks/{}.csv", kTracks[t])));
      options.laps = short_ ? kShortLaps : laps_of_endurance(options.track);
      options.pedal_sensors = pedal_sensors(master_config(options.vehicle, loaded.origin));
      const std::vector<SocJudgedCase> judged =
          cases_of(condition.settings.empty(), flattest_slope_v(options.vehicle.cell));
      std::vector<SocCase> told;
      std::vector<SocMark> marks;
      for (const SocJudgedCase& each : judged) {
        told.push_back(each.told);
        marks.push_back(each.mark);
      }
      const double done = static_cast<double>(out.size()), all = static_cast<double>(tracks * cars.size());
      const auto show = [&](double fraction) {
        const double share = (done + std::max(0.0, fraction)) / all;
        progress.show(fmt::format("driving {}, {}", kTracks[t], condition.name), share);
        return interrupted();
      };
      out.push_back({kTracks[t], condition.name, marks, run_soc_trial(options, told, show)});
      if (interrupted()) return out;
      refuse_unjudged(car_.vehicle, out.back(), short_);
    }
  }
  return out;
}

std::vector<SocRecordingResult> SocTestCommand::read_all(const DataFolder& data, ProgressLine& progress) const {
  std::vector<SocRecordingResult> out;
  if (recordings_.files.empty()) return out;
  const CellParameters cell = load_cell(data, cell_, "cell");
  CarOptions car = car_;
  const std::string path = std::filesystem::absolute(data.find("cells", cell_, "cell")).string();
  for (const char* alone : {"battery.cells_in_series=1", "battery.cells_in_parallel=1", "sensors.temperature_count=1"})
    car.settings.emplace_back(alone);
  car.settings.push_back("battery.cell=" + path);
  car.settings.emplace_back("bms.soc_method=ekf");
  const LoadedVehicle loaded = car.load_car(data);
  const bms::Config config = bms_config(loaded.parameters, loaded.origin);
  const std::vector<std::optional<RoleMap>> maps = recordings_.role_maps(data);
  for (const std::string& file : recordings_.files) {
    progress.show("reading " + file, static_cast<double>(out.size()) / static_cast<double>(maps.size()));
    const std::optional<RoleMap>& map = maps.at(out.size());
    const CellLog log = read_cell_log(file, map ? &*map : nullptr, data, recordings_.whole());
    out.push_back(run_soc_recording(log, cell, config, temperature_c_.value_or(cell.reference_temperature_c)));
    if (interrupted()) break;
  }
  return out;
}

int SocTestCommand::run(const DataFolder& data) {
  car_.refuse_own("soc-test", {"bms.soc_method"});
  catch_interrupt();
  std::optional<AtomicFile> json;
  if (!json_.empty()) json.emplace(json_);
  ProgressLine progress("soc-test");
  const std::vector<SocRecordingResult> recordings = read_all(data, progress);
  const std::vector<SocDriveResult> drives =
      only_recordings_ || interrupted() ? std::vector<SocDriveResult>{} : drive_all(data, progress);
  progress.end();
  if (interrupted()) {
    std::fprintf(stderr, "Interrupted; no result file was written.\n");
    return exit_code_of_interrupt();
  }
  fmt::print(summary_stream({json_}), "{}", soc_test_text(drives, recordings));
  if (json) {
    json->write(soc_test_json(drives, recordings));
    json->commit();
  }
  return kExitOk;
}

}  // namespace voltlap::plant
