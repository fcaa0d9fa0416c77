// SPDX-License-Identifier: Apache-2.0
// The commands of `voltlap log` that read recordings.
#include "apps/guarded_main.hpp"
#include "apps/log_convert_command.hpp"
#include "apps/log_decode_command.hpp"
#include "apps/log_group.hpp"
#include "apps/log_info_command.hpp"
#include "apps/log_plot_command.hpp"
#include "apps/other_programs.hpp"
#include "apps/program.hpp"

namespace {

using namespace voltlap::plant;

void add_record(CLI::App& app) { log_group(app).add_subcommand("record", kLogRecord); }

int run(int argc, char** argv) {
  hand_record_over(argc, argv);
  return run_commands<LogInfoCommand, LogCheckCommand, LogDecodeCommand, LogConvertCommand, LogPlotCommand>(argc, argv,
                                                                                                            add_record);
}

}  // namespace

int main(int argc, char** argv) { return guarded_main(run, argc, argv); }
