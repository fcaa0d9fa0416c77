// SPDX-License-Identifier: Apache-2.0
// The command line `voltlap`: the car driven, on a bus in this process or on a CAN interface.
#include "apps/bus_errors.hpp"
#include "apps/charge_command.hpp"
#include "apps/compare_command.hpp"
#include "apps/ecu_command.hpp"
#include "apps/endurance_command.hpp"
#include "apps/firmware_tables_command.hpp"
#include "apps/guarded_main.hpp"
#include "apps/lap_command.hpp"
#include "apps/list_command.hpp"
#include "apps/log_record_command.hpp"
#include "apps/new_command.hpp"
#include "apps/other_programs.hpp"
#include "apps/plant_command.hpp"
#include "apps/program.hpp"
#include "apps/rig_command.hpp"
#include "apps/track_command.hpp"

namespace {

using namespace voltlap::plant;

int run(int argc, char** argv) {
  hand_over(argc, argv);
  return with_bus_errors([&] {
    return run_commands<EnduranceCommand, ChargeCommand, CompareCommand, FirmwareTablesCommand, LapCommand, ListCommand,
                        NewCommand, PlantCommand, EcuCommand, LogRecordCommand, RigCommand, TrackCommand>(
        argc, argv, add_other_commands);
  });
}

}  // namespace

int main(int argc, char** argv) { return guarded_main(run, argc, argv); }
