// SPDX-License-Identifier: Apache-2.0
#include "apps/play_command.hpp"

#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <thread>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/other_programs.hpp"
#include "apps/progress_line.hpp"
#include "apps/run_recorder.hpp"
#include "core/errors.hpp"
#include "io/play/play_socket.hpp"
#include "port/host/bus_error.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSlowest = 1e-3, kFastest = 1e6;  // times the recording's own pace
constexpr std::uint64_t kMostRounds = 1'000'000'000;
constexpr const char* kUnpaced = "max";

/// 0: as fast as the bus takes them; nothing for what is no speed.
std::optional<double> parse_speed(const std::string& text) {
  if (text == kUnpaced) return 0.0;
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value >= kSlowest && value <= kFastest ? std::optional(value) : std::nullopt;
}

CLI::Validator speed_check() {
  const auto check = [](const std::string& text) {
    if (parse_speed(text)) return std::string();
    return fmt::format("found {}; expected a number from {:g} to {:g}, or max. Correct it, or leave the flag out.",
                       text, kSlowest, kFastest);
  };
  return {check, "1|N|max"};
}

CLI::Validator id_check() {
  const auto check = [](const std::string& text) {
    IdRange range;
    if (parse_id_range(text, range)) return std::string();
    return fmt::format("found {}; expected identifiers in hexadecimal such as 6B0, 18FF1234 or 6B0-6BF, with commas "
                       "between them. Correct the flag.", text);
  };
  return {check, "HEX[,HEX|RANGE]"};
}

/// Says now and then how far it is, from a thread of its own: a terminal that is slow delays no frame.
class PlayProgress {
 public:
  PlayProgress(const Player& player, std::uint64_t frames)
      : thread_([this, &player, frames](const std::stop_token& stop) { show(player, frames, stop); }) {}

 private:
  static void show(const Player& player, std::uint64_t frames, const std::stop_token& stop) {
    ProgressLine line("play");
    while (!stop.stop_requested()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      const std::uint64_t sent = player.sent();
      const std::uint64_t of_round = frames == 0 ? 0 : sent % frames;
      line.show(fmt::format("{} frames sent{}", sent, sent >= frames ? ", and again" : ""),
                static_cast<double>(of_round) / static_cast<double>(frames));
    }
  }

  std::jthread thread_;
};

}  // namespace

PlayCommand::PlayCommand(CLI::App& app) : command_(app.add_subcommand("play", what_it_does("play"))) {
  recording_.add(*command_);
  bus_.add_interface(*command_)->required();
  command_->add_option("--speed", speed_, "Times the recording's own pace; max: as fast as the bus takes the frames")
      ->check(speed_check())
      ->capture_default_str();
  command_->add_option("--from", choice_.from_s, "Only frames from this time after the first on [s]")
      ->check(number_from_zero());
  command_->add_option("--to", choice_.to_s, "Only frames up to this time after the first [s]")
      ->check(number_from_zero());
  command_->add_option("--channel", choice_.channel, "Only the frames of this interface or channel of the recording")
      ->check(some_name("an interface or channel of the recording"));
  command_
      ->add_option("--id", ids_,
                   "Only these identifiers, in hexadecimal; a range with -; more than three digits: 29 bits. May be "
                   "given again")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(id_check());
  loop_flag_ = command_->add_option("--loop", rounds_, "Again and again, N times in all; without a number until Ctrl-C")
                   ->type_name("[N]")
                   ->expected(0, 1)
                   ->check(whole_number(1, kMostRounds));
  command_->footer(
      "The whole recording is read before the first frame is sent. Every frame has its absolute time; one that is late "
      "moves no other.\n"
      "Example: voltlap play drive.log.gz --bus vcan0 --speed 2 --id 6B0-6BF,18FF1234 --loop\n"
      "Exit code: 0; 1 the recording breaks off, what stands before it was played; 2 usage, recording or interface; 3 "
      "the bus\nwent down or took no frames; 130 interrupted.");
}

PlayList PlayCommand::read(const DataFolder& data) {
  for (const std::string& text : ids_) {
    IdRange range;
    if (parse_id_range(text, range)) choice_.ids.push_back(range);
  }
  ProgressLine progress("play");
  const auto opened = recording_.open(recording_.dbc(data), true);
  ReadPlayList read = read_play_list(*opened, recording_.path(), choice_, [&](std::size_t frames) {
    progress.show(fmt::format("reading {}: {} frames", recording_.path(), frames), 0.0);
  });
  progress.end();
  fmt::print("{}", remarks_text(recording_.path(), opened->summary()));
  for (const IdRange& range : read.absent) fmt::print("  {} is not among the frames\n", id_range_text(range));
  broken_ = !opened->summary().broken.empty();
  return std::move(read.frames);
}

PlayPlan PlayCommand::plan(const PlayList& list) const {
  PlayPlan out;
  out.speed = parse_speed(speed_).value_or(1.0);
  if (loop_flag_->count() > 0) out.rounds = rounds_;
  if (out.rounds == 1 || list.round_ns() > 0) return out;
  throw InputError("--loop", "frames that have no interval between them", "two frames at different times at least",
                   "Leave the flag out, or choose more frames");
}

void PlayCommand::announce(const PlayList& list, const PlayPlan& plan) const {
  const std::string pace = plan.speed == 0.0 ? "as fast as the bus takes them"
                                             : fmt::format("{:g} times as fast as recorded", plan.speed);
  fmt::print("{}: {} frames, {:.3f} s, onto {}, {}{}\n", recording_.path(), list.size(),
             1e-9 * static_cast<double>(list.span_ns()), bus_.interface,
             plan.speed == 1.0 ? "as recorded" : pace,
             plan.rounds == 1   ? ""
             : plan.rounds == 0 ? ", again and again"
                                : fmt::format(", {} times", plan.rounds));
  std::fflush(stdout);
}

void PlayCommand::sum_up(const PlayList& list, const PlayPlan& plan, const PlayResult& result,
                         const PlaySocket& socket) const {
  const double took_s = 1e-9 * static_cast<double>(result.took_ns);
  const std::uint64_t rest = result.sent % list.size();
  fmt::print("  {} frames sent{}\n", result.sent,
             rest == 0 ? "" : fmt::format(", of the last round {} of {}", rest, list.size()));
  if (plan.speed > 0.0) {
    const double planned_s = 1e-9 * static_cast<double>(result.planned_ns);
    fmt::print("  in {:.6f} s, by the recording {:.6f} s: {:+.3f} ms\n", took_s, planned_s, 1e3 * (took_s - planned_s));
    fmt::print("  late: median {:.3f} ms, 99.9 % {:.3f} ms, worst {:.3f} ms\n", result.lateness.quantile_ms(0.5),
               result.lateness.quantile_ms(0.999), result.lateness.worst_ms());
    fmt::print("  spacings off by more than {:g} ms: {} of {}\n", Lateness::kSpacing_ms,
               result.lateness.spacings_off(), result.sent > 0 ? result.sent - 1 : 0);
  } else {
    fmt::print("  in {:.6f} s, recorded in {:.6f} s: {:.0f} frames a second\n", took_s,
               1e-9 * static_cast<double>(list.span_ns()),
               took_s > 0.0 ? static_cast<double>(result.sent) / took_s : 0.0);
  }
  fmt::print("  waited for a full queue {} times\n", socket.retries());
}

int PlayCommand::run(const DataFolder& data) {
  const PlayList list = read(data);
  const PlayPlan what = plan(list);
  PlaySocket socket(bus_.interface, list.flexible());
  MonotonicClock clock;
  Player player(list, what, clock, socket);
  announce(list, what);
  catch_interrupt();
  try {
    const PlayProgress progress(player, list.size());
    player.run(interrupted);
  } catch (const port::BusDownError&) {
    sum_up(list, what, player.result(), socket);
    throw;
  }
  sum_up(list, what, player.result(), socket);
  if (interrupted()) return exit_code_of_interrupt();
  return broken_ ? kExitDefects : kExitOk;
}

}  // namespace voltlap::plant
