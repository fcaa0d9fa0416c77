// SPDX-License-Identifier: Apache-2.0
#include "apps/shadow_command.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <thread>

#include "apps/bus_capture.hpp"
#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/other_programs.hpp"
#include "apps/replay_pack.hpp"
#include "apps/run_recorder.hpp"
#include "core/errors.hpp"
#include "core/input_files.hpp"
#include "io/logs/role_map.hpp"
#include "io/temporary_folder.hpp"
#include "replay/replay_text.hpp"

namespace voltlap::plant {
namespace {

constexpr double kFirst_s = 3.0, kLeast_s = 2.0;  // between two replays
constexpr double kShare = 0.25;                   // of a core, for replays
constexpr std::chrono::milliseconds kLook{50};
constexpr int kNice = 10;

/// Of the calling thread.
double cpu_s() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A replay of the growing log is given up when the shadow is to end.
struct GivenUp {};

/// The log does not move while it is read.
class Held {
 public:
  explicit Held(BusCapture& capture) : capture_(&capture) { capture.hold(); }
  ~Held() { release(); }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  void release() {
    if (capture_ != nullptr) capture_->release();
    capture_ = nullptr;
  }

 private:
  BusCapture* capture_;
};

}  // namespace

ShadowCommand::ShadowCommand(CLI::App& app) : command_(app.add_subcommand("shadow", what_it_does("shadow"))) {
  bus_.add_interface(*command_)->required();
  command_->add_option("--map", asked_.map, "Role map: name or path; default: a shipped map that fits");
  finding_.add(*command_);
  command_->add_option("--pack", asked_.pack,
                       "Cell, pack or vehicle file (TOML), name or path: what the firmware knows of the cells. Without "
                       "it SOC and limits say `no cell model`");
  command_
      ->add_option("--log", log_,
                   "Keep what is heard as a candump log, plain: there from the beginning, complete at the end")
      ->type_name("FILE")
      ->check(some_name("a path"));
  command_->add_option("--for", for_s_, "End after so long [s]; default: at Ctrl-C")->check(positive_number());
  outputs_.add(*command_);
  add_settings(*command_, asked_);
  command_->footer(
      "It sends nothing. What is heard is replayed again and again, as often as a quarter of a core allows; at the end "
      "the\nwhole recording once more: summary and files are those of voltlap replay of that log.\n"
      "Example: voltlap shadow --bus can0 --pack pack.toml --log drive.log --report drive.html\n"
      "See docs/play_and_shadow.md. Exit code: 0 ended by Ctrl-C or --for; 1 frames were lost; 2 usage, interface, "
      "file, or\na recording that cannot be replayed, with why; 3 the bus went down.");
}

/// What will not mend itself while the bus is heard.
void ShadowCommand::check(const DataFolder& data) const {
  refuse_shared_files({{"--log", log_}, {"--json", outputs_.json}, {"--csv", outputs_.csv},
                       {"--report", outputs_.report}, {"--write-map", finding_.write_map}});
  for (const std::string& file : finding_.dbc_files) note_input(file);
  finding_.check_needed(!asked_.map.empty());
  if (!asked_.map.empty()) static_cast<void>(load_role_map(data.find("maps", asked_.map, "--map")));
  if (!asked_.pack.empty()) static_cast<void>(pack_of_own(data, asked_.pack, asked_.settings));
}

void ShadowCommand::replay_so_far(BusCapture& capture, const std::string& log, const DataFolder& data) {
  if (capture.frames() == 0) {
    stage_ = Stage::kWaits;
    state_ = "waits for a frame";
    next_ = Clock::now() + kLook;
    return;
  }
  const double begin_s = cpu_s();
  ReplayAsked asked = asked_;
  asked.log = log;
  MapFinding finding = finding_;
  finding.write_map.clear();
  try {
    Held held(capture);
    const ReplayResult result = replay_by_role(asked, finding, data, [&](const std::string&, double fraction) {
      if (fraction >= 0.5) held.release();
      if (interrupted() || capture.ended()) throw GivenUp();
    });
    const std::vector<Disagreement> news = disagreements_.of(result);
    if (!news.empty()) status_.clear();
    for (const Disagreement& one : news) {
      fmt::print(outputs_.stream(), "{:.1f} to {:.1f} s: {}\n", one.begin_s, one.end_s, one.what);
    }
    std::fflush(outputs_.stream());
    stage_ = Stage::kReplays;
    state_ = fmt::format("{} | replayed {:.1f} s", status_text(result), result.duration_s);
  } catch (const InputError& error) {
    stage_ = Stage::kWaits;
    state_ = "not yet: " + waiting_text(error.what());
  }
  const double cost_s = cpu_s() - begin_s;
  const double pause_s = std::max(kLeast_s, cost_s * (1.0 / kShare - 1.0));
  next_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(pause_s));
}

void ShadowCommand::watch(BusCapture& capture, const std::string& log, const DataFolder& data) {
  const auto begin = Clock::now();
  const auto elapsed_s = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  next_ = begin + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kFirst_s));
  Stage shown = Stage::kNone;
  while (!interrupted() && !capture.ended() && (for_s_ == 0.0 || elapsed_s() < for_s_)) {
    std::this_thread::sleep_for(kLook);
    try {
      if (Clock::now() >= next_) replay_so_far(capture, log, data);
    } catch (const GivenUp&) {
      break;
    }
    status_.show(fmt::format("shadow {:.0f} s, {} frames | {}", elapsed_s(), capture.frames(), state_),
                 stage_ != shown);
    shown = stage_;
  }
  status_.clear();
}

void ShadowCommand::conclude(const std::string& log, const DataFolder& data) {
  ReplayAsked asked = asked_;
  asked.log = log;
  ReplayResult result = replay_by_role(asked, finding_, data, [](const std::string&, double) {});
  if (log_.empty()) result.log = bus_.interface;
  outputs_.write(result);
  fmt::print(outputs_.stream(), "{}", replay_text(result));
}

int ShadowCommand::run(const DataFolder& data) {
  check(data);
  port::SocketCan socket(bus_.interface, {.filters = {port::kEveryFrame}, .error_frames = true, .time_stamps = true});
  std::optional<TemporaryFolder> scratch;
  if (log_.empty()) scratch.emplace();
  GrowingFile log(scratch ? scratch->path() + "/heard.log" : log_);
  catch_interrupt();
  BusCapture capture(socket, log);
  ::setpriority(PRIO_PROCESS, 0, kNice);  // of this thread: the one that listens comes first, and so does all else
  watch(capture, log.path(), data);
  capture.stop();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);  // the log is complete
  if (capture.frames() == 0 && !capture.failure()) {
    throw InputError(bus_.interface, "no frame in all that time", "a bus on which the car speaks",
                     "Check wiring and bit rate: ip -details link show " + bus_.interface);
  }
  try {
    conclude(log.path(), data);
  } catch (const InputError& error) {
    if (!capture.failure()) throw;
    fmt::print(stderr, "voltlap: {}\n", error.what());
  }
  if (capture.failure()) std::rethrow_exception(capture.failure());
  if (capture.dropped() == 0) return kExitOk;
  fmt::print(stderr, "voltlap shadow: the log is not whole: {} frames came faster than they were read. Allow a larger "
             "buffer (as root: sysctl net.core.rmem_max=8388608)\n", capture.dropped());
  return kExitDefects;
}

}  // namespace voltlap::plant
