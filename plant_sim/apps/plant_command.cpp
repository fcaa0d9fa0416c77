// SPDX-License-Identifier: Apache-2.0
#include "apps/plant_command.hpp"

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/run_recorder.hpp"
#include "io/bus/lockstep_bus.hpp"
#include "io/bus/realtime_bus.hpp"
#include "port/host/lockstep_member.hpp"

namespace voltlap::plant {
namespace {

constexpr can::Member kMembers[] = {can::Member::kBms, can::Member::kMaster, can::Member::kLogger, can::Member::kHil};
constexpr double kDurationMin_s = 0.01, kDurationMax_s = 1e6;
constexpr double kReadyMin_s = 0.5, kReadyMax_s = 3600.0;

std::vector<std::string> member_names() {
  std::vector<std::string> out;
  for (const can::Member m : kMembers) out.emplace_back(port::member_name(m));
  return out;
}

DriverKind driver_kind(const std::string& name) {
  return name == "stand" ? DriverKind::kStand : name == "none" ? DriverKind::kNobody : DriverKind::kLaps;
}

}  // namespace

PlantCommand::PlantCommand(CLI::App& app)
    : command_(app.add_subcommand("plant", "Run car, sensors and driver as a process on a CAN interface")),
      run_(*command_) {
  bus_.add_interface(*command_)->required();
  CLI::Option* realtime = bus_.add_realtime(*command_);
  bus_.add_lockstep(*command_, realtime);
  command_->add_option("--members", members_, "Nodes that step with the plant, of: bms,master,logger,hil")
      ->delimiter(',')
      ->check(one_of(member_names()))
      ->excludes(realtime)
      ->capture_default_str();
  command_->add_option("--ready-within", ready_within_s_, "Longest wait for all members [s of wall time]")
      ->type_name("S")
      ->check(number_between(kReadyMin_s, kReadyMax_s))
      ->excludes(realtime)
      ->capture_default_str();
  command_
      ->add_option("--driver", driver_,
                   "auto: powers up and drives the laps; stand: powers up and stands; none: nobody")
      ->check(one_of({"auto", "stand", "none"}))
      ->capture_default_str();
  command_->add_option("--duration", duration_s_, "Ends then, as finished [s of simulated time since power-on]")
      ->type_name("S")
      ->check(number_between(kDurationMin_s, kDurationMax_s));
  command_->add_flag(
      "--keep-going", keep_going_,
      "What would fail the run is noted in --json, and the run goes on; always so with --driver stand or none");
  command_->footer(
      "A harness on the bus takes over pedals and switches (DriverOverride), plants faults (PlantFault) and ends "
      "the run\n"
      "(StopRequest): can_dbc/lockstep.dbc. With --driver stand or none the run ends only so, or with --duration.\n"
      "Example: voltlap plant --bus vcan0 --laps 1    beside: voltlap ecu bms --bus vcan0, voltlap ecu master "
      "--bus vcan0\n"
      "Exit code: 0 finished, 2 usage, interface, or a member that is not READY, 3 the run failed, a node was lost "
      "or the\n"
      "interface went down, 130 interrupted.");
}

std::vector<can::Member> PlantCommand::members() const {
  std::vector<can::Member> out;
  for (const std::string& name : members_) {
    for (const can::Member m : kMembers) {
      if (name == port::member_name(m)) out.push_back(m);
    }
  }
  return out;
}

int PlantCommand::run(const DataFolder& data) {
  EnduranceOptions options = run_.options(data);
  options.driver = driver_kind(driver_);
  options.duration_s = duration_s_;
  options.keep_going = keep_going_;
  catch_interrupt();
  if (bus_.realtime) {
    RealtimeBus bus(bus_.interface);
    return run_.drive(data, options, bus, &bus);
  }
  LockstepBus bus({.interface = bus_.interface,
                   .members = members(),
                   .lost_after_s = bus_.lost_after_s,
                   .ready_within_s = ready_within_s_,
                   .pace = bus_.pace,
                   .interrupted = interrupted});
  if (!bus.await_members()) return exit_code_of_interrupt();
  const int code = run_.drive(data, options, bus, &bus);
  bus.stop();
  return code;
}

}  // namespace voltlap::plant
