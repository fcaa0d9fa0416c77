// SPDX-License-Identifier: Apache-2.0
#include "apps/other_programs.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

struct OtherCommand {
  const char *name, *program, *what;
};

constexpr OtherCommand kOthers[] = {
    {"bench-test", "voltlap-learn", "Plan, rehearse and run battery tests on a virtual bench"},
    {"explain", "voltlap-explain", "What a simulation gets wrong about a log: the cause, its size, the gain"},
    {"log", "voltlap-logs", "Recordings of a CAN bus: record, look at, check, plot, decode, convert"},
    {"identify", "voltlap-learn", "Parameter tables of a cell from its measured tests or drives"},
    {"limit-test", "voltlap-learn", "The BMS's current limits against the plant, and what each kind of limit costs"},
    {"soc-test", "voltlap-learn", "The BMS's state of charge against the truth, with errors of all kinds"},
    {"play", "voltlap-replay", "A recording onto a CAN interface at its own pace, for live nodes and tools"},
    {"replay", "voltlap-replay", "A recorded log through the production firmware: what it would have done"},
    {"shadow", "voltlap-replay", "The firmware beside the car's own unit on a live bus, silent: where they disagree"},
    {"validate", "voltlap-learn", "A cell file against recordings of that cell that it was not made from"},
};

const OtherCommand* find(std::string_view command) {
  const auto* found = std::find_if(std::begin(kOthers), std::end(kOthers),
                                   [&](const OtherCommand& other) { return command == other.name; });
  return found == std::end(kOthers) ? nullptr : found;
}

/// The causes stand where they are made: `voltlap list causes` is answered there.
bool asks_for_causes(int argc, char** argv) {
  return argc > 2 && std::strcmp(argv[1], "list") == 0 &&
         std::any_of(argv + 2, argv + argc, [](const char* word) { return std::strcmp(word, "causes") == 0; });
}

[[noreturn]] void become(const char* program, char** argv) {
  const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  execv((folder / program).c_str(), argv);
  throw InputError(std::string("voltlap ") + argv[1], (folder / program).string() + " is not there or does not start",
                   "the program that has this command, built",
                   std::string("Start it with ./voltlap, which builds it, or build the target ") + program);
}

/// What a bus carries is recorded by the program that drives.
bool records(int argc, char** argv) {
  return argc > 2 && std::strcmp(argv[1], "log") == 0 && std::strcmp(argv[2], "record") == 0;
}

}  // namespace

const char* what_it_does(const char* command) {
  const OtherCommand* other = find(command);
  VOLTLAP_DEMAND(other != nullptr);
  return other->what;
}

void add_other_commands(CLI::App& app) {
  for (const OtherCommand& other : kOthers) {
    const auto has = [&](CLI::App* command) { return command->get_name() == other.name; };
    if (app.get_subcommands(has).empty()) app.add_subcommand(other.name, other.what);
  }
}

void hand_over(int argc, char** argv) {
  if (argc < 2 || records(argc, argv)) return;
  const OtherCommand* other = asks_for_causes(argc, argv) ? find("explain") : find(argv[1]);
  if (other == nullptr) return;
  become(other->program, argv);
}


void hand_record_over(int argc, char** argv) {
  if (records(argc, argv)) become("voltlap", argv);
}

}  // namespace voltlap::plant
