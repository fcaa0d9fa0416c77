// SPDX-License-Identifier: Apache-2.0
#include "apps/rig_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <limits>

#include "apps/exit_code.hpp"
#include "apps/firmware_config.hpp"
#include "apps/flag_checks.hpp"
#include "apps/run_recorder.hpp"
#include "apps/supplied_boards.hpp"
#include "apps/supplied_loop.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"

namespace voltlap::plant {
namespace {

constexpr int kLapsMax = 10'000;

/// The harness sees all there is to see.
class Unwatched final : public EnduranceObserver {
 public:
  void on_frame(std::uint32_t, Sender, const Frame&) override {}
  void on_sample(const TimeSample&) override {}
  void on_progress(double, double) override {}
  [[nodiscard]] bool stop_requested() override { return interrupted(); }
};

}  // namespace

RigCommand::RigCommand(CLI::App& app)
    : command_(app.add_subcommand("rig", "Run car and firmware in one process for a harness on two pipes")) {
  car_.add_vehicle(*command_);
  car_.add_track(*command_);
  command_->add_option("--laps", laps_, "Number of laps of --driver auto; default: as many as fit into 22 km")
      ->check(whole_number(1, kLapsMax));
  command_
      ->add_option("--driver", driver_,
                   "auto: powers up and drives the laps; stand: powers up and stands; none: nobody")
      ->check(one_of({"auto", "stand", "none"}))
      ->capture_default_str();
  command_->add_option("--seed", seed_, "Seed of everything random; the same seed gives the same run")
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  ecu_.add(*command_);
  command_->add_option("--json", json_, "With --ecu qemu or process: what the boards say of themselves at the end")
      ->type_name("FILE");
  command_->footer(
      "Standard input and output carry batches of frames: plant_sim/io/bus/harness_bus.hpp has their form. A harness "
      "takes\n"
      "over pedals, plants faults, resets a control unit and ends the run with the frames of can_dbc/lockstep.dbc.\n"
      "With --ecu qemu or process BMS and master controller have a board each; a reset is one of its processor.\n"
      "It is what `voltlap faults` and `voltlap hil run --channel process` start; a person has no use for it.\n"
      "Exit code: 0 the harness ended the run, 2 usage, or standard input is a terminal, 3 the run failed.");
}

int RigCommand::run(const DataFolder& data) {
  if (isatty(STDIN_FILENO) != 0) {
    throw InputError("voltlap rig", "a terminal as standard input", "the pipe of a harness",
                     "Start it by `voltlap faults` or `voltlap hil run --channel process`");
  }
  const LoadedVehicle loaded = car_.load_car(data);
  EnduranceOptions options;
  options.vehicle = loaded.parameters;
  options.track = car_.load_course(data);
  options.laps = laps_.value_or(laps_of_endurance(options.track));
  options.lap_start = car_.start();
  options.seed = seed_;
  options.driver = driver_ == "auto"    ? DriverKind::kLaps
                   : driver_ == "stand" ? DriverKind::kStand
                                        : DriverKind::kNobody;
  options.keep_going = true;
  const master::Config master = master_config(options.vehicle, loaded.origin);
  options.pedal_sensors = pedal_sensors(master);
  const bms::Config bms = bms_config(options.vehicle, loaded.origin);
  catch_interrupt();
  std::signal(SIGPIPE, SIG_IGN);  // a harness that has died is a failed run, and said
  if (!ecu_.outside()) {
    if (!json_.empty()) throw InputError("--json", "--ecu inside", "--ecu qemu or process", "Name one of them");
    SuppliedLoop ecus(bms, master);
    return drive(options, ecus);
  }
  SuppliedBoards boards(ecu_, bms, master);
  const int code = drive(options, boards);
  if (code != kExitOk) return code;
  boards.end();
  if (!json_.empty()) {
    AtomicFile json(json_);
    json.write(ecu_result_json(boards.result()));
    json.complete();
    json.commit();
  }
  return code;
}

int RigCommand::drive(const EnduranceOptions& options, SuppliedEcus& ecus) const {
  HarnessBus bus(ecus, STDIN_FILENO, STDOUT_FILENO);
  Unwatched observer;
  const EnduranceResult result = run_endurance(options, bus, observer);
  if (result.stopped) return exit_code_of_interrupt();
  if (!result.finished) {
    fmt::print(stderr, "voltlap rig: {}\n", result.failure_cause);
    return kExitFailedRun;
  }
  return kExitOk;
}

}  // namespace voltlap::plant
