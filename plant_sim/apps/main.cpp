// SPDX-License-Identifier: Apache-2.0
// The command line `voltlap`.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/bench_test_command.hpp"
#include "apps/ecu_command.hpp"
#include "apps/endurance_command.hpp"
#include "apps/exit_code.hpp"
#include "apps/explain_command.hpp"
#include "apps/firmware_tables_command.hpp"
#include "apps/flag_checks.hpp"
#include "apps/guarded_main.hpp"
#include "apps/identify_command.hpp"
#include "apps/lap_command.hpp"
#include "apps/list_command.hpp"
#include "apps/log_command.hpp"
#include "apps/plant_command.hpp"
#include "apps/validate_command.hpp"
#include "core/errors.hpp"
#include "port/host/bus_error.hpp"

namespace {

using namespace voltlap::plant;

int run(int argc, char** argv) {
  CLI::App app("Voltlap: an electric race car, its battery and its control firmware on one CAN bus.", "voltlap");
  app.set_version_flag("--version", "voltlap " VOLTLAP_VERSION);
  app.require_subcommand(1);
  app.failure_message(usage_message);
  BenchTestCommand bench_test(app);
  EnduranceCommand endurance(app);
  ExplainCommand explanation(app);
  FirmwareTablesCommand firmware_tables(app);
  IdentifyCommand identification(app);
  LapCommand lap(app);
  ListCommand list(app);
  PlantCommand plant(app);
  EcuCommand ecu(app);
  LogCommand log(app);
  ValidateCommand validation(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitInput;
  }
  const DataFolder data(VOLTLAP_DATA_FOLDER);
  if (bench_test.chosen()) return bench_test.run(data);
  if (endurance.chosen()) return endurance.run(data);
  if (explanation.chosen()) return explanation.run(data);
  if (firmware_tables.chosen()) return firmware_tables.run(data);
  if (identification.chosen()) return identification.run(data);
  if (validation.chosen()) return validation.run(data);
  if (lap.chosen()) return lap.run(data);
  if (plant.chosen()) return plant.run(data);
  if (ecu.chosen()) return ecu.run(data);
  if (log.chosen()) return log.run();
  return list.run(data);
}

/// The bus has errors of its own: an interface that is not there is an input, one that goes down fails the run.
int run_with_bus(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const voltlap::port::BusSetupError& error) {
    throw InputError(error.what());
  } catch (const voltlap::port::BusDownError& error) {
    std::fprintf(stderr, "voltlap: %s\n", error.what());
    return kExitFailedRun;
  }
}

}  // namespace

int main(int argc, char** argv) { return guarded_main(run_with_bus, argc, argv); }
