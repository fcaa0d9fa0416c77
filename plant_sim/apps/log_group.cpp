// SPDX-License-Identifier: Apache-2.0
#include "apps/log_group.hpp"

namespace voltlap::plant {

CLI::App& log_group(CLI::App& app) {
  const auto found = app.get_subcommands([](CLI::App* command) { return command->get_name() == "log"; });
  if (!found.empty()) return *found.front();
  CLI::App* group = app.add_subcommand("log", "Recordings of a CAN bus: record, look at, check, plot, decode, convert");
  group->require_subcommand(1);
  return *group;
}

}  // namespace voltlap::plant
