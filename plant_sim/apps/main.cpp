// SPDX-License-Identifier: Apache-2.0
// The command line `voltlap`.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "apps/ecu_command.hpp"
#include "apps/endurance_command.hpp"
#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/lap_command.hpp"
#include "apps/list_command.hpp"
#include "apps/log_command.hpp"
#include "apps/plant_command.hpp"
#include "core/errors.hpp"
#include "port/host/bus_error.hpp"

namespace {

using namespace voltlap::plant;

int run(int argc, char** argv) {
  CLI::App app("Voltlap: an electric race car, its battery and its control firmware on one CAN bus.", "voltlap");
  app.set_version_flag("--version", "voltlap " VOLTLAP_VERSION);
  app.require_subcommand(1);
  app.failure_message(usage_message);
  EnduranceCommand endurance(app);
  LapCommand lap(app);
  ListCommand list(app);
  PlantCommand plant(app);
  EcuCommand ecu(app);
  LogCommand log(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitInput;
  }
  const DataFolder data(VOLTLAP_DATA_FOLDER);
  if (endurance.chosen()) return endurance.run(data);
  if (lap.chosen()) return lap.run(data);
  if (plant.chosen()) return plant.run(data);
  if (ecu.chosen()) return ecu.run(data);
  if (log.chosen()) return log.run();
  return list.run(data);
}

int complain(const char* text, int code) {
  std::fprintf(stderr, "voltlap: %s\n", text);
  return code;
}

/// The exit code, once what was printed has arrived; a full disk or a reader that went away is an error as well.
int with_output_flushed(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  return complain(
      "standard output: found that it does not take what is printed; expected a reader, or a disk with room. "
      "Make room, or send it elsewhere.",
      kExitInput);
}

}  // namespace

int main(int argc, char** argv) {
  // A full disk, a file limit or a reader that went away is then an error with a message, not a sudden end.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return with_output_flushed(run(argc, argv));
  } catch (const InputError& error) {
    return complain(error.what(), kExitInput);
  } catch (const OutputError& error) {
    return complain(error.what(), kExitInput);
  } catch (const voltlap::port::BusSetupError& error) {
    return complain(error.what(), kExitInput);
  } catch (const voltlap::port::BusDownError& error) {
    return complain(error.what(), kExitFailedRun);
  } catch (const std::bad_alloc&) {
    return complain("found that the memory ran out; expected an input that fits into it. Use a smaller one.",
                    kExitFault);
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) return with_output_flushed(kExitInput);  // what the print function threw
    std::fprintf(stderr, "voltlap: found a defect of the program (%s). Please report it with the command line.\n",
                 error.what());
    return kExitFault;
  }
}
