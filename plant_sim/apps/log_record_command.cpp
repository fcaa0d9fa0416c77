// SPDX-License-Identifier: Apache-2.0
#include "apps/log_record_command.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/log_group.hpp"
#include "apps/run_recorder.hpp"
#include "can_dbc/tables.hpp"
#include "io/atomic_file.hpp"
#include "io/bus/candump_file.hpp"
#include "port/host/lockstep_member.hpp"
#include "port/host/pacer.hpp"
#include "port/host/silence.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSilence_s = 2.0;

/// A frame that was lost on the way makes a log that looks whole and is not.
void refuse_loss(const port::SocketCan& socket) {
  if (socket.counters().dropped == 0) return;
  throw OutputError(fmt::format(
      "the log is not whole: {} frames came faster than they were read. Allow a larger buffer (as root: "
      "sysctl net.core.rmem_max=8388608), or slow the run down with --pace; no log was written",
      socket.counters().dropped));
}

}  // namespace

LogRecordCommand::LogRecordCommand(CLI::App& app)
    : command_(log_group(app).add_subcommand("record", kLogRecord)) {
  bus_.add_interface(*command_)->required();
  add_output_file(*command_, "--candump", file_, "The log; compressed when the name ends in .gz")->required();
  bus_.add_realtime(*command_);
  command_->footer(
      "In lockstep it is a member of the run (voltlap plant --members bms,master,logger): simulated time, no frame "
      "lost, and\n"
      "the same file, line for line, as of a run in one process. With --realtime it writes what it hears until "
      "Ctrl-C, with\n"
      "the time of day.\n"
      "Exit code: 0 the run is over, 2 usage, interface or file, 3 the plant fell silent, 130 interrupted.");
}

int LogRecordCommand::run(const DataFolder&) {
  catch_interrupt();
  return bus_.realtime ? log_in_real_time() : log_in_lockstep();
}

int LogRecordCommand::log_in_lockstep() const {
  using port::Wake;
  CandumpFile log(file_, static_cast<std::uint32_t>(can::kTickMs));
  port::LockstepMember member(bus_.interface, can::Member::kLogger, {port::kEveryFrame});
  std::vector<port::Arrival> arrivals;
  const TxQueue nothing;
  port::Silence silence;
  while (!interrupted()) {
    if (!member.started()) member.announce();
    const Wake wake = member.wait();
    if (wake != Wake::kNone || !member.started()) silence.end();
    if (wake == Wake::kStep) {
      arrivals.clear();
      member.data().drain(arrivals);
      for (const port::Arrival& a : arrivals) {
        if (!port::is_lockstep(a.frame.id)) log.on_frame(member.tick(), Sender::kPlant, a.frame);
      }
      member.done(nothing);
    } else if (wake == Wake::kStop && !interrupted()) {
      refuse_loss(member.data());
      log.commit();
      return kExitOk;
    } else if (wake == Wake::kNone && member.started() && silence.go_on() > kSilence_s) {
      fmt::print(stderr, "voltlap log record: no word from the plant for {} s after tick {}; the log ends there\n",
                 kSilence_s, member.tick());
      log.commit();
      return kExitFailedRun;
    }
  }
  return exit_code_of_interrupt();
}

int LogRecordCommand::log_in_real_time() const {
  AtomicFile log(file_);
  port::SocketCan socket(bus_.interface, {.filters = {port::kEveryFrame}, .error_frames = true, .time_stamps = true});
  port::Pacer pacer(can::kTickMs * 1000, port::Lag::kForget);
  std::vector<port::Arrival> arrivals;
  for (bool last = false; !last;) {
    last = interrupted();
    if (!last) pacer.wait();
    arrivals.clear();
    socket.drain(arrivals);
    for (const port::Arrival& a : arrivals) {
      log.write(candump_line(std::chrono::microseconds(a.time_us), a.frame, bus_.interface) + '\n');
    }
  }
  refuse_loss(socket);
  log.commit();
  return kExitOk;
}

}  // namespace voltlap::plant
