// SPDX-License-Identifier: Apache-2.0
#include "apps/endurance_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "apps/exit_code.hpp"
#include "apps/firmware_config.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/flag_checks.hpp"
#include "apps/progress_line.hpp"
#include "apps/run_recorder.hpp"
#include "apps/supervisor.hpp"
#include "can_dbc/tables.hpp"
#include "core/errors.hpp"
#include "io/bus/bus_load_table.hpp"
#include "race/report/run_notes.hpp"
#include "race/report/summary_table.hpp"
#include "race/track/outline.hpp"

namespace voltlap::plant {
namespace {

constexpr int kLapsMax = 10'000;

/// Nothing but progress: of a run whose result is a number beside another.
class Rerunning final : public EnduranceObserver {
 public:
  explicit Rerunning(const std::string& reason) : line_("without the limit " + reason) {}
  void on_frame(std::uint32_t, Sender, const Frame&) override {}
  void on_sample(const TimeSample&) override {}
  void on_progress(double fraction, double) override { line_.show("driving", std::max(0.0, fraction)); }
  [[nodiscard]] bool stop_requested() override { return interrupted(); }

 private:
  ProgressLine line_;
};

/// Flying laps end on the line of the course; what is driven by the clock ends where the car is then.
std::optional<double> finish_m(const RunDescription& run, const EnduranceResult& result) {
  const bool on_the_line = result.finished && run.lap_start == "flying" && result.laps == run.laps;
  return on_the_line ? std::optional(run.laps * *run.course_length_m) : std::nullopt;
}

}  // namespace

EnduranceRun::EnduranceRun(CLI::App& command) {
  car_.add_vehicle(command);
  CLI::Option* track = car_.add_track(command);
  CLI::Option* start = car_.add_lap_start(command);
  CLI::Option* laps = command.add_option("--laps", laps_, "Number of laps; default: as many as fit into 22 km")
                          ->check(whole_number(1, kLapsMax));
  command
      .add_option("--drive", drive_,
                  "A recorded drive instead of a track: CSV with time_s,speed_mps[,accelerator,brake]")
      ->excludes(track)
      ->excludes(start)
      ->excludes(laps);
  command.add_option("--cells", cells_, "all: every cell in series; representative: one cell, scaled (faster)")
      ->check(one_of({"all", "representative"}))
      ->capture_default_str();
  command.add_option("--seed", seed_, "Seed of everything random; the same seed gives the same run")
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  add_output_file(command, "--json", json_, "Write the result as JSON, also when the run fails");
  CLI::Option* csv =
      add_output_file(command, "--csv", csv_, "Write the time series as CSV; compressed when the name ends in .gz");
  command.add_option("--rate", rate_hz_, "Lines per second of --csv: 10 or an even part of it")
      ->needs(csv)
      ->check(positive_number())
      ->capture_default_str();
  command.add_flag("--bus-load", bus_load_,
                   "Count every bit on the bus and print how full it was, by message; by identifier in --json. "
                   "Always so on an interface");
  add_output_file(command, "--candump", candump_, "Write every frame as a candump log, with simulated time");
  add_output_file(command, "--report", report_,
                  "Write a report as one HTML file for any browser, offline, also when the run fails");
}

EnduranceOptions EnduranceRun::options(const DataFolder& data) const {
  refuse_shared_files({{"--json", json_}, {"--csv", csv_}, {"--candump", candump_}, {"--report", report_}});
  EnduranceOptions out;
  const LoadedVehicle car = car_.load_car(data);
  out.vehicle = car.parameters;
  if (drive_.empty()) {
    out.track = car_.load_course(data);
    out.laps = laps_.value_or(laps_of_endurance(out.track));
  } else {
    out.drive = load_drive(drive_);
    out.laps = 1;
  }
  if (cells_ == "representative" && !out.vehicle.battery.cells.empty()) {
    throw InputError("--cells representative", "settings of single cells (battery.cells.<n>.*)",
                     "cells that are all equal", "Use --cells all, or leave these settings out");
  }
  out.lap_start = car_.start();
  out.representative_cell = cells_ == "representative";
  out.seed = seed_;
  out.pedal_sensors = pedal_sensors(master_config(out.vehicle, car.origin));
  (void)bms_config(out.vehicle, car.origin);  // a refusal names the line
  return out;
}

CLI::Option* EnduranceRun::add_limit_costs(CLI::App& command) {
  return command.add_flag("--limit-costs", limit_costs_,
                          "What each limit that bound cost in time and charge: a run more for each, without it. Always "
                          "so with --report, within one process");
}

std::vector<LimitCost> EnduranceRun::costs_of(const DataFolder& data, const EnduranceOptions& chosen,
                                              const EnduranceResult& result) const {
  return limit_costs(result, chosen.vehicle, [&](const std::string& reason, const std::vector<std::string>& settings) {
    CarOptions car = car_;
    car.settings.insert(car.settings.end(), settings.begin(), settings.end());
    EnduranceOptions lifted = chosen;
    lifted.vehicle = car.load_car(data).parameters;
    lifted.pedal_sensors = pedal_sensors(master_config(lifted.vehicle));
    FirmwareLoop firmware(lifted.vehicle);
    Rerunning observer(reason);
    return run_endurance(lifted, firmware, observer);
  });
}

RunDescription EnduranceRun::description(const EnduranceOptions& options) const {
  return {.vehicle = options.vehicle.name,
          .course = options.drive ? options.drive->name : options.track.name,
          .lap_start = options.drive ? "drive" : car_.lap_start,
          .cells = cells_,
          .settings = car_.settings,
          .seed = seed_,
          .laps = options.laps,
          .course_length_m = options.drive ? std::nullopt : std::optional(options.track.length_m()),
          .closing_gap_m = options.drive ? std::nullopt : std::optional(closing_gap_m(options.track))};
}

std::string EnduranceRun::summary_of(const DataFolder& data, const EnduranceOptions& chosen,
                                     const EnduranceResult& result) const {
  const RunDescription run = description(chosen);
  const std::string reference_file = data.path("reference/endurance.csv");
  const auto reference = result.finished ? find_reference(reference_file, run) : std::nullopt;
  std::string out = summary_table(run, result, reference);
  if (run.closing_gap_m) {
    out += fmt::format("  course: {}\n", course_text(*run.course_length_m, *run.closing_gap_m));
  }
  for (const std::string& note : run_notes(run, chosen.vehicle, result)) out += fmt::format("  note: {}\n", note);
  RunDescription standing = run;
  standing.lap_start = "standing";
  if (run.lap_start == "flying" && find_reference(reference_file, standing)) {
    out += "  the reference study repeats a lap from rest: --lap-start standing prints its row beside the run\n";
  }
  return out;
}

void EnduranceRun::open_outputs(const RunDescription& run, const EnduranceOptions& chosen, bool count_load,
                                RunRecorder& recorder) const {
  if (!csv_.empty()) recorder.series.emplace(csv_, rate_hz_, run, chosen.vehicle);
  if (count_load) recorder.load.emplace(can::kTickMs, static_cast<std::uint32_t>(can::kBitRate));
  if (!report_.empty()) recorder.report.emplace(report_);
  if (!candump_.empty()) recorder.candump.emplace(candump_, static_cast<std::uint32_t>(can::kTickMs));
}

int EnduranceRun::drive(const DataFolder& data, const EnduranceOptions& chosen, PlantBus& bus,
                        const SocketBus* socket, EcuProgram* ecu) const {
  const RunDescription run = description(chosen);
  RunRecorder recorder;
  catch_interrupt();  // before there is a file that must not stay behind
  // Opened before the run: a path that cannot be written is known at once.
  std::optional<AtomicFile> json;
  if (!json_.empty()) json.emplace(json_);
  open_outputs(run, chosen, bus_load_ || socket != nullptr, recorder);
  std::optional<LoadedVehicle> car;  // once more, with the places that its numbers come from
  if (recorder.report) car = car_.load_car(data);

  const auto begin = std::chrono::steady_clock::now();
  const EnduranceResult result = run_endurance(chosen, bus, recorder);
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  recorder.end_progress();
  if (result.stopped) {
    fmt::print(stderr, "Interrupted after {:.1f} s of the race; no result file was written.\n", result.failure_time_s);
    return exit_code_of_interrupt();
  }

  if (ecu != nullptr && !ecu->failed()) ecu->end();

  std::optional<std::vector<LimitCost>> costs;
  if (socket == nullptr && (limit_costs_ || recorder.report)) costs = costs_of(data, chosen, result);
  if (interrupted()) {
    fmt::print(stderr, "Interrupted while the costs of the limits were driven; no result file was written.\n");
    return exit_code_of_interrupt();
  }

  recorder.complete();
  const TraceHash::Result hash = recorder.hash.finish();
  const auto statistics = socket != nullptr ? std::optional(socket->statistics()) : std::nullopt;
  const auto ecu_result = ecu != nullptr ? std::optional(ecu->result()) : std::nullopt;
  const auto load = recorder.load ? std::optional(recorder.load->result()) : std::nullopt;
  if (json) {
    recorder.trace.close(result.total_time_s, finish_m(run, result));
    json->write(run_result_json(run, chosen.vehicle,
                                {.result = result,
                                 .hash = hash,
                                 .wall_s = wall_s,
                                 .bus = statistics ? &*statistics : nullptr,
                                 .ecu = ecu_result ? &*ecu_result : nullptr,
                                 .load = load ? &*load : nullptr,
                                 .limit_costs = costs ? &*costs : nullptr,
                                 .trace = &recorder.trace}));
    json->complete();
  }
  if (recorder.report) {
    recorder.report->finish({.run = run,
                             .car = *car,
                             .track = chosen.drive ? std::nullopt : std::optional(chosen.track),
                             .result = result,
                             .hash = hash,
                             .wall_s = wall_s,
                             .limit_costs = costs.value_or(std::vector<LimitCost>())});
  }
  recorder.commit();
  if (json) json->commit();
  std::FILE* summary = summary_stream({json_, csv_, candump_, report_});
  fmt::print(summary, "{}", summary_of(data, chosen, result));
  if (costs) fmt::print(summary, "{}", costs->empty() ? "  no limit cost anything\n" : limit_costs_text(*costs));
  const double simulated_s = result.ticks * can::kTickMs * 1e-3;
  if (statistics) fmt::print(summary, "{}", bus_statistics_text(*statistics, simulated_s, wall_s));
  if (load) fmt::print(summary, "{}", bus_load_table(*load));
  if (ecu != nullptr) fmt::print(summary, "{}", ecu->summary());
  fmt::print(summary, "  computed in {:.1f} s, seed {}\n", wall_s, run.seed);
  const bool whole = result.lost_nodes.empty() || chosen.keep_going || chosen.driver != DriverKind::kLaps;
  return result.finished && whole ? kExitOk : kExitFailedRun;
}

EnduranceCommand::EnduranceCommand(CLI::App& app)
    : command_(
          app.add_subcommand("endurance", "Drive an endurance with the firmware in the loop and print the result")),
      run_(*command_) {
  CLI::Option* bus = bus_.add_interface(*command_);
  CLI::Option* realtime = bus_.add_realtime(*command_)->needs(bus);
  bus_.add_lockstep(*command_, realtime);
  ecu_.add(*command_)->excludes(bus);
  run_.add_limit_costs(*command_)->excludes(bus);
  for (const char* flag : {"--pace", "--lost-after"}) command_->get_option(flag)->needs(bus);
  command_->footer(
      "A FILE named - is standard output; the summary then goes to standard error.\n"
      "Example: voltlap endurance --set vehicle.mass_kg=219 --json run.json\n"
      "With --bus, plant, BMS and master controller are processes of their own on the interface, in lockstep: the\n"
      "same frames as in one process, for every CAN tool to see.\n"
      "With --ecu qemu the image of a Cortex-M4 (./voltlap image) runs in QEMU, the plant here: the same frames, too.\n"
      "Exit code: 0 finished, 2 usage or input, 3 the run failed (with time and cause), 130 interrupted.");
}

int EnduranceCommand::run(const DataFolder& data) {
  const EnduranceOptions options = run_.options(data);
  if (!bus_.interface.empty() && run_.candump() == AtomicFile::kStandardOutput) {
    throw InputError("--candump with --bus", "- (standard output)", "a file",
                     "Give a name; the logger is a process of its own");
  }
  if (!bus_.interface.empty()) return supervise(*command_, bus_, run_.candump());
  if (ecu_.outside()) {
    catch_interrupt();
    EcuProgram ecu(ecu_, bms_config(options.vehicle), master_config(options.vehicle));
    return run_.drive(data, options, ecu.bus(), nullptr, &ecu);
  }
  FirmwareLoop firmware(options.vehicle);
  InProcessLoop loop(firmware);
  return run_.drive(data, options, loop, nullptr);
}

}  // namespace voltlap::plant
