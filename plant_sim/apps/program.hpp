// SPDX-License-Identifier: Apache-2.0
// What the programs of the command line have in common: each is some commands, of which one is chosen and run.
#pragma once
#include <CLI/CLI.hpp>
#include <tuple>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "core/parameter_file.hpp"

namespace voltlap::plant {

/// `app` with name, description and version; commands are still to be added.
void introduce(CLI::App& app);

/// The cars, cells, tracks and maps that come with the project.
[[nodiscard]] DataFolder shipped_data();

/// Adds the commands to a command line, reads it and runs the one that is chosen. `add_others` adds what the program
/// names in its help and does not do itself.
template <class... Commands>
int run_commands(int argc, char** argv, void (*add_others)(CLI::App&) = nullptr) {
  CLI::App app;
  introduce(app);
  std::tuple<Commands...> commands((static_cast<void>(sizeof(Commands)), app)...);
  if (add_others != nullptr) add_others(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitInput;
  }
  const DataFolder data = shipped_data();
  int code = kExitInput;
  const auto run_if_chosen = [&](auto& command) {
    if (command.chosen()) code = command.run(data);
  };
  std::apply([&](auto&... command) { (run_if_chosen(command), ...); }, commands);
  return code;
}

}  // namespace voltlap::plant
