// SPDX-License-Identifier: Apache-2.0
#include "apps/ecu_command.hpp"

#include <memory>

#include "app/bms_node.hpp"
#include "app/master_node.hpp"
#include "apps/ecu_process.hpp"
#include "apps/firmware_config.hpp"
#include "apps/flag_checks.hpp"
#include "apps/run_recorder.hpp"
#include "can_dbc/tables.hpp"

namespace voltlap::plant {
namespace {

template <std::size_t N>
std::vector<port::CanFilter> filters_of(const can::MessageRow (&rows)[N]) {
  std::vector<port::CanFilter> out;
  for (const can::MessageRow& row : rows) out.push_back(port::only(row.id));
  return out;
}

/// The node lives as long as the function that steps it.
template <class Node, class Config, std::size_t N>
EcuNode ecu(can::Member member, const Config& config, const can::MessageRow (&rows)[N]) {
  auto node = std::make_shared<Node>(config);
  return {member, filters_of(rows), [node](Instant now, FrameView rx, TxQueue& tx) { node->tick(now, rx, tx); }};
}

}  // namespace

EcuCommand::EcuCommand(CLI::App& app)
    : command_(app.add_subcommand("ecu", "Run control units as a process on a CAN interface")) {
  command_->add_option("which", which_, "bms, master, or all (both in one process)")
      ->required()
      ->check(one_of({"bms", "master", "all"}));
  bus_.add_interface(*command_)->required();
  car_.add_vehicle(*command_);
  bus_.add_realtime(*command_);
  command_->footer(
      "Steps with the plant (voltlap plant) on the same interface until that ends. When the plant falls silent for "
      "2 s, the\n"
      "nodes step by the wall clock to their safe state and end after 5 s. Give --vehicle and --set as for the "
      "plant.\n"
      "Example: voltlap ecu bms --bus vcan0\n"
      "Exit code: 0 the run is over, 2 usage or interface, 3 the plant fell silent or the interface went down, 130 "
      "interrupted.");
}

int EcuCommand::run(const DataFolder& data) {
  const LoadedVehicle loaded = car_.load_car(data);
  const VehicleParameters& car = loaded.parameters;
  std::vector<EcuNode> nodes;
  if (which_ != "master") {
    nodes.push_back(ecu<app::BmsNode>(can::Member::kBms, bms_config(car, loaded.origin), can::kBmsRx));
  }
  if (which_ != "bms") {
    nodes.push_back(ecu<app::MasterNode>(can::Member::kMaster, master_config(car, loaded.origin), can::kMasterRx));
  }
  catch_interrupt();
  return bus_.realtime ? run_in_real_time(bus_.interface, std::move(nodes))
                       : run_in_lockstep(bus_.interface, std::move(nodes));
}

}  // namespace voltlap::plant
