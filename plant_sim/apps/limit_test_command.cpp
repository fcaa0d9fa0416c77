// SPDX-License-Identifier: Apache-2.0
#include "apps/limit_test_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <optional>
#include <random>

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
constexpr int kMomentsPerDrive = 50, kMostBarren = 20;

using Settings = std::vector<std::string>;

/// Cells that age together and differ a little, and perhaps one that is worse than the others.
void draw_cells(std::mt19937_64& random, int cells, Settings& out) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  const double resistance = 1.0 + uniform(random), capacity = 1.0 - 0.2 * uniform(random);
  const int weak = uniform(random) < 0.5 ? static_cast<int>(uniform(random) * cells) : -1;
  const double worse = 1.0 + uniform(random);
  for (int k = 0; k < cells; ++k) {
    const double r = resistance * (1.0 + 0.05 * normal(random)) * (k == weak ? worse : 1.0);
    const double c = capacity * (1.0 + 0.01 * normal(random)) * (k == weak ? 0.9 : 1.0);
    out.push_back(fmt::format("battery.cells.{}.resistance_scale={:.4f}", k + 1, std::clamp(r, 0.5, 4.0)));
    out.push_back(fmt::format("battery.cells.{}.capacity_scale={:.4f}", k + 1, std::clamp(c, 0.5, 1.1)));
  }
}

/// Cells that the BMS is told nothing of: resistance and capacity of all, resistance of the worst.
struct Ageing {
  const char* words;
  double resistance, capacity, worst;
};
constexpr Ageing kAgeing[] = {{"every cell 15 % less capacity, 40 % more resistance", 1.4, 0.85, 1.4},
                              {"one cell aged to three times its resistance", 1.0, 1.0, 3.0}};
constexpr int kWorst = 8;  // from 1, or the last

/// Races in which limits bind: the bound of the voltage is so much above the cell's own.
constexpr double kRaised_v = 0.5;

void age_cells(const Ageing& ageing, int cells, Settings& out) {
  for (int k = 1; k <= cells; ++k) {
    const double resistance = k == std::min(kWorst, cells) ? ageing.worst : ageing.resistance;
    out.push_back(fmt::format("battery.cells.{}.resistance_scale={}", k, resistance));
    out.push_back(fmt::format("battery.cells.{}.capacity_scale={}", k, ageing.capacity));
  }
}

Settings at_temperature(double c) {
  return {fmt::format("environment.ambient_c={:.1f}", c), fmt::format("battery.initial_temperature_c={:.1f}", c),
          "assertions.battery_temperature_max_c=60"};
}

}  // namespace

LimitTestCommand::LimitTestCommand(CLI::App& app)
    : command_(app.add_subcommand("limit-test", what_it_does("limit-test"))) {
  car_.add_vehicle(*command_);
  command_->add_option("--states", states_, "Random states of drawn drives")
      ->capture_default_str()
      ->check(whole_number(1, 100'000));
  command_->add_option("--seed", seed_, "Draws the drives and the states")
      ->capture_default_str()
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()));
  command_->add_option("--only", only_, "states: no whole endurance; races: no states")
      ->check(CLI::IsMember({"states", "races"}));
  add_output_file(*command_, "--json", json_, "Write every state and race as JSON");
  command_->footer(
      "States: drives with drawn charge, temperature and ageing, of which the BMS is told nothing, under limits that\n"
      "look ahead. From 120 s on the current that each kind of limit allows flows in a copy of the plant's pack for\n"
      "1, 10 and 30 s; the lowest cell (of charge the highest) ends at its bound, or not.\n"
      "Races: 22 km with aged cells, cold and hot, the resistance told to the BMS half of the cell file's and twice\n"
      "of it, and cells that are held half a volt above their own bound, so that the limits bind.\n"
      "Example: voltlap limit-test --states 200 --only states --json limits.json\n"
      "Exit code: 0 all was measured, marks met or not, 2 usage or input, 130 interrupted.");
}

EnduranceOptions LimitTestCommand::drive_of(const DataFolder& data, const std::string& track,
                                            const Settings& settings) const {
  CarOptions car = car_;
  car.settings.insert(car.settings.end(), settings.begin(), settings.end());
  car.settings.emplace_back("bms.soc_method=ekf");
  car.settings.emplace_back("bms.limit_method=ahead");
  const LoadedVehicle loaded = car.load_car(data);
  EnduranceOptions options;
  options.vehicle = loaded.parameters;
  options.track = load_track(data.path(fmt::format("tracks/{}.csv", track)));
  options.laps = laps_of_endurance(options.track);
  options.pedal_sensors = pedal_sensors(master_config(options.vehicle, loaded.origin));
  return options;
}

void LimitTestCommand::ask_states(const DataFolder& data, ProgressLine& progress, LimitTestResult& out) const {
  const int cells = car_.load_car(data).parameters.battery.cells_in_series;
  const auto wanted = static_cast<std::size_t>(states_) * 2 * kTriedHorizons;
  int barren = 0;
  for (std::uint64_t drive = 0; out.moments.size() < wanted && !interrupted(); ++drive) {
    std::mt19937_64 random(seed_ * 1'000'003 + drive);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    Settings settings = at_temperature(-10.0 + 55.0 * uniform(random));
    settings.push_back(fmt::format("battery.initial_soc={:.3f}", 0.3 + 0.7 * uniform(random)));
    draw_cells(random, cells, settings);
    EnduranceOptions options = drive_of(data, kTracks[drive % std::size(kTracks)], settings);
    options.laps = 4 + static_cast<int>(5 * uniform(random));
    const double before = static_cast<double>(out.moments.size()) / static_cast<double>(wanted);
    const double part = static_cast<double>(std::min(kMomentsPerDrive, states_)) / states_;
    const auto show = [&](double fraction) {
      progress.show("states", std::min(1.0, before + part * std::max(0.0, fraction)));
      return interrupted();
    };
    const int moments = std::min(kMomentsPerDrive, states_);
    std::vector<LimitMoment> found = run_limit_drive({options, seed_ * 1'000'003 + drive, moments}, show);
    out.moments.insert(out.moments.end(), found.begin(), found.end());
    barren = found.empty() ? barren + 1 : 0;
    if (barren >= kMostBarren && !interrupted()) {
      throw InputError("vehicle " + car_.vehicle, fmt::format("{} drives in a row that end before 120 s", barren),
                       "a car that drives: a limit is asked after two minutes of it",
                       "Try it with ./voltlap endurance first");
    }
  }
  if (out.moments.size() > wanted) out.moments.resize(wanted);
}

void LimitTestCommand::drive_races(const DataFolder& data, ProgressLine& progress, LimitTestResult& out) const {
  const VehicleParameters given = car_.load_car(data).parameters;
  const int cells = given.battery.cells_in_series;
  const double least_v = given.bms.cell_voltage_min_v.value_or(given.cell.voltage_min_v) + kRaised_v;
  constexpr double kTemperatures_c[] = {-10.0, 20.0, 45.0}, kTold[] = {0.5, 1.0, 2.0};
  constexpr bms::LimitMethod kMethods[] = {bms::LimitMethod::kEquation, bms::LimitMethod::kTable,
                                           bms::LimitMethod::kAhead};
  const std::size_t all = std::size(kAgeing) * std::size(kTemperatures_c) * std::size(kTold) * std::size(kMethods);
  for (const Ageing& ageing : kAgeing) {
    for (const double temperature : kTemperatures_c) {
      Settings settings = at_temperature(temperature);
      age_cells(ageing, cells, settings);
      settings.push_back(fmt::format("bms.cell_voltage_min_v={}", least_v));
      const EnduranceOptions options = drive_of(data, kTracks[0], settings);
      for (const double told : kTold) {
        for (const bms::LimitMethod method : kMethods) {
          const auto show = [&](double fraction) {
            const double done = static_cast<double>(out.races.size()) + std::max(0.0, fraction);
            progress.show(fmt::format("races, {:.0f} degC", temperature), done / static_cast<double>(all));
            return interrupted();
          };
          const LimitRaceResult race = run_limit_race(options, method, told, show);
          out.races.push_back({ageing.words, temperature, told, method, race});
          if (interrupted()) return;
        }
      }
    }
  }
}

int LimitTestCommand::run(const DataFolder& data) {
  // Before anything is measured: states take minutes.
  car_.refuse_own("limit-test",
                  {"bms.soc_method", "bms.limit_method", "environment.ambient_c", "battery.initial_temperature_c"});
  if (only_ != "races") car_.refuse_own("limit-test", {"battery.initial_soc"});
  if (only_ != "states") car_.refuse_own("limit-test", {"bms.cell_voltage_min_v"});
  catch_interrupt();
  std::optional<AtomicFile> json;
  if (!json_.empty()) json.emplace(json_);
  ProgressLine progress("limit-test");
  LimitTestResult result;
  result.seed = seed_;
  if (only_ != "races") ask_states(data, progress, result);
  if (only_ != "states" && !interrupted()) drive_races(data, progress, result);
  progress.end();
  if (interrupted()) {
    std::fprintf(stderr, "Interrupted; no result file was written.\n");
    return exit_code_of_interrupt();
  }
  fmt::print(summary_stream({json_}), "{}", limit_test_text(result));
  if (json) {
    json->write(limit_test_json(result));
    json->commit();
  }
  return kExitOk;
}

}  // namespace voltlap::plant
