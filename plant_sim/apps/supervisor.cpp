// SPDX-License-Identifier: Apache-2.0
#include "apps/supervisor.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <vector>

#include "apps/child_process.hpp"
#include "apps/exit_code.hpp"
#include "can_dbc/car.hpp"
#include "can_dbc/lockstep.hpp"
#include "can_dbc/pm100.hpp"
#include "can_dbc/tables.hpp"
#include "codec/amk_frames.hpp"
#include "core/demand.hpp"
#include "io/bus/quiet_bus.hpp"
#include "port/host/bus_error.hpp"
#include "port/host/lockstep_member.hpp"

namespace voltlap::plant {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kLook{100};       // at the bus; a dead child is seen at once
constexpr milliseconds kSafeWithin{4500};  // 2 s of silence, and what the firmware needs then
constexpr int kBySignal = 128;           // as shells count
constexpr milliseconds kGrace{3000};     // for a process to end by itself, and again after it was asked

/// Whatever asks for an end, and the death of a child, as something to wait for, from here on.
class Signals {
 public:
  Signals() {
    ::sigemptyset(&set_);
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGCHLD}) ::sigaddset(&set_, number);
    ::sigprocmask(SIG_BLOCK, &set_, &before_);
    file_ = ::signalfd(-1, &set_, SFD_NONBLOCK | SFD_CLOEXEC);
  }
  ~Signals() {
    ::close(file_);
    ::sigprocmask(SIG_SETMASK, &before_, nullptr);
  }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  /// Waits for any of them; the number of one with which somebody wants the run to end, else 0.
  [[nodiscard]] int wait(milliseconds longest) const {
    pollfd poll{file_, POLLIN, 0};
    ::poll(&poll, 1, static_cast<int>(longest.count()));
    int end = 0;
    for (signalfd_siginfo info{}; ::read(file_, &info, sizeof info) == sizeof info;) {
      if (info.ssi_signo != SIGCHLD) end = static_cast<int>(info.ssi_signo);
    }
    return end;
  }

 private:
  sigset_t set_{}, before_{};
  int file_ = -1;
};

/// The flags that were given to `command`, for another command: those in `names`, or all but those.
std::vector<std::string> given_flags(const CLI::App& command, const std::vector<std::string>& names, bool only_these) {
  std::vector<std::string> out;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    const bool named = std::find(names.begin(), names.end(), name) != names.end();
    if (named != only_these) continue;
    for (const std::string& value : option->results()) out.push_back(fmt::format("--{}={}", name, value));
  }
  return out;
}

struct Node {
  can::Member member;  ///< kNone: the plant
  std::unique_ptr<ChildProcess> process;
};

class Supervisor {
 public:
  Supervisor(const CLI::App& command, const BusOptions& bus, const std::string& candump)
      : bus_(bus), watch_(bus.interface, {.filters = {port::kEveryFrame}}) {
    require_quiet_bus(watch_, bus.realtime ? Pacing::kRealTime : Pacing::kLockstep, arrivals_);
    watch_.filter({port::only(can::Sync::kId)});
    auto plant = given_flags(command, {"candump"}, false);
    plant.insert(plant.begin(), "plant");
    if (!bus.realtime) plant.push_back(candump.empty() ? "--members=bms,master" : "--members=bms,master,logger");
    auto car = given_flags(command, {"vehicle", "set", "bus", "realtime"}, true);
    for (const can::Member m : {can::Member::kBms, can::Member::kMaster}) {
      std::vector<std::string> ecu = {"ecu", port::member_name(m)};
      ecu.insert(ecu.end(), car.begin(), car.end());
      start(m, port::member_name(m), ecu);
    }
    if (!candump.empty()) {
      std::vector<std::string> log = {"log", "record", "--candump=" + candump};
      const auto where = given_flags(command, {"bus", "realtime"}, true);
      log.insert(log.end(), where.begin(), where.end());
      start(can::Member::kLogger, "logger", log);
    }
    start(can::Member::kNone, "plant", plant);  // last: who listens shall hear it from its first frame
  }

  int run() {
    VOLTLAP_DEMAND(nodes_.back().member == can::Member::kNone);  // the plant, which the others follow
    while (plant().runs()) {
      if (const int number = signals_.wait(kLook); number != 0) interrupt(number);
      note_tick();
      for (Node& node : nodes_) note_end(node);
    }
    const auto code = plant().exit_code();
    if (!code && interrupted_ == 0) watch_safe_state();
    end_all();
    if (interrupted_ != 0) return kBySignal + interrupted_;
    return worst(code.value_or(kExitFailedRun));
  }

 private:
  [[nodiscard]] ChildProcess& plant() { return *nodes_.back().process; }

  void start(can::Member member, const std::string& name, const std::vector<std::string>& arguments) {
    nodes_.push_back({member, std::make_unique<ChildProcess>(name, arguments)});
  }

  /// The logger first, so that it does not take the end for a good one; the others follow the plant.
  void interrupt(int number) {
    interrupted_ = number;
    for (const Node& node : nodes_) {
      if (node.member == can::Member::kLogger || node.member == can::Member::kNone) node.process->signal(number);
    }
  }

  /// What came since the last look; nothing once the interface is down. The nodes see that too, end, and say so: the
  /// plant with the result of the run, which a supervisor that ended first would cut off.
  const std::vector<port::Arrival>& look() {
    arrivals_.clear();
    on_bus([&] { watch_.drain(arrivals_); });
    return arrivals_;
  }

  template <class Action>
  void on_bus(const Action& action) {
    if (bus_down_) return;
    try {
      action();
    } catch (const port::BusDownError&) {
      bus_down_ = true;
    }
  }

  void note_tick() {
    for (const port::Arrival& a : look()) {
      can::Sync sync;
      if (!decode(a.frame, sync)) continue;
      tick_ = sync.tick;
      over_ = over_ || sync.stop;
    }
  }

  void note_end(Node& node) {
    if (!node.process->has_just_ended()) return;
    note_tick();
    const bool expected = node.process->exit_code() == kExitOk || interrupted_ != 0 || over_;
    if (node.member == can::Member::kNone && node.process->exit_code()) return;
    if (expected) return;
    tell(fmt::format("node {} (process {}) {}{}", node.process->name(), node.process->pid(),
                     node.process->end_text(), when()));
    lost_ = true;
    if (node.member == can::Member::kNone || bus_.realtime) return;
    can::MemberLost lost;
    lost.member = node.member;
    Frame frame;
    encode(lost, frame);
    on_bus([&] { watch_.send(&frame, 1); });
  }

  [[nodiscard]] std::string when() const {
    return tick_ ? fmt::format(" at tick {}, {:.2f} s after power-on", *tick_, *tick_ * can::kTickMs * 1e-3) : "";
  }

  /// Nobody paces the control units any more: what they command by themselves is on the bus.
  void watch_safe_state() {
    watch_.filter({port::only(can::ContactorCommand::kId), port::only(can::InverterCommand::kId),
                   port::only(can::Pm100Command::kId), port::only(can::AmkSetpointsFrontLeft::kId),
                   port::only(can::AmkSetpointsFrontRight::kId), port::only(can::AmkSetpointsRearLeft::kId),
                   port::only(can::AmkSetpointsRearRight::kId)});
    const auto begin = Clock::now();
    std::optional<bool> contactors_open, torque_zero;
    std::array<bool, codec::kWheels> wheel_zero{};
    while (Clock::now() - begin < kSafeWithin && (contactors_open != true || torque_zero != true)) {
      if (signals_.wait(kLook) != 0) break;
      for (const port::Arrival& a : look()) {
        can::ContactorCommand contactors;
        can::InverterCommand inverter;
        can::Pm100Command torque;
        codec::AmkSetpoints setpoints;
        std::size_t wheel = 0;
        if (decode(a.frame, contactors)) {
          contactors_open = !contactors.air_plus_close && !contactors.air_minus_close && !contactors.precharge_close;
        } else if (decode(a.frame, inverter)) {
          torque_zero = !inverter.enable && inverter.phase_current_ma == 0;
        } else if (decode(a.frame, torque)) {
          torque_zero = !torque.enable && torque.torque_mnm == 0;
        } else if (codec::decode_amk(a.frame, wheel, setpoints)) {
          wheel_zero[wheel] = !setpoints.enable && setpoints.torque_limit_positive_ppm == 0 &&
                              setpoints.torque_limit_negative_ppm == 0;
          torque_zero = std::all_of(wheel_zero.begin(), wheel_zero.end(), [](bool zero) { return zero; });
        }
      }
    }
    const auto text = [](const std::optional<bool>& safe) { return !safe ? "not seen" : *safe ? "yes" : "NO"; };
    tell(fmt::format("{:.1f} s after that, on the bus: contactors commanded open: {}, torque command zero: {}",
                     std::chrono::duration<double>(Clock::now() - begin).count(), text(contactors_open),
                     text(torque_zero)));
  }

  /// They end with the run; who does not is asked to, and then made to.
  void end_all() {
    const bool patient = plant().exit_code().has_value() && !bus_.realtime && interrupted_ == 0;
    if (patient) await_ends(kGrace);
    for (Node& node : nodes_) node.process->signal(SIGTERM);
    await_ends(kGrace);
    for (Node& node : nodes_) {
      if (node.process->runs()) tell(fmt::format("node {} does not end and is killed", node.process->name()));
    }
  }

  void await_ends(milliseconds longest) {
    const auto end = Clock::now() + longest;
    over_ = true;
    while (any_runs() && Clock::now() < end) {
      static_cast<void>(signals_.wait(kLook));
      for (Node& node : nodes_) note_end(node);
    }
  }

  [[nodiscard]] bool any_runs() const {
    return std::any_of(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.process->runs(); });
  }

  /// A plant that is content does not hide that a node was lost, or that the log was not written.
  [[nodiscard]] int worst(int plant_code) const {
    if (plant_code != kExitOk) return plant_code;
    for (const Node& node : nodes_) {
      const std::optional<int> code = node.process->exit_code();
      // In real time end_all()'s signal ends them; they tell its number when it comes before the plant's stop.
      const bool asked_to_end = bus_.realtime && (code == kExitInterrupted || code == 128 + SIGTERM);
      if (node.process->exit_code() != kExitOk && !asked_to_end)
        return node.process->exit_code().value_or(kExitFailedRun);
    }
    return lost_ ? kExitFailedRun : kExitOk;
  }

  static void tell(const std::string& text) { fmt::print(stderr, "voltlap: {}\n", text); }

  Signals signals_;
  const BusOptions& bus_;
  port::SocketCan watch_;
  std::vector<Node> nodes_;
  std::vector<port::Arrival> arrivals_;
  std::optional<std::uint32_t> tick_;
  int interrupted_ = 0;  ///< the number of the signal
  bool over_ = false, lost_ = false, bus_down_ = false;
};

}  // namespace

int supervise(const CLI::App& command, const BusOptions& bus, const std::string& candump) {
  return Supervisor(command, bus, candump).run();
}

}  // namespace voltlap::plant
