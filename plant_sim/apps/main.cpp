// SPDX-License-Identifier: Apache-2.0
// The command line `voltlap`.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "apps/endurance_command.hpp"
#include "apps/exit_code.hpp"
#include "apps/lap_command.hpp"
#include "apps/list_command.hpp"
#include "core/errors.hpp"

namespace {

using namespace voltlap::plant;

int run(int argc, char** argv) {
  CLI::App app("Voltlap: an electric race car, its battery and its control firmware on one CAN bus.", "voltlap");
  app.set_version_flag("--version", "voltlap " VOLTLAP_VERSION);
  app.require_subcommand(1);
  EnduranceCommand endurance(app);
  LapCommand lap(app);
  ListCommand list(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitInput;
  }
  const DataFolder data(VOLTLAP_DATA_FOLDER);
  if (endurance.chosen()) return endurance.run(data);
  if (lap.chosen()) return lap.run(data);
  return list.run(data);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const InputError& error) {
    std::fprintf(stderr, "voltlap: %s\n", error.what());
  } catch (const OutputError& error) {
    std::fprintf(stderr, "voltlap: %s\n", error.what());
  }
  return kExitInput;
}
