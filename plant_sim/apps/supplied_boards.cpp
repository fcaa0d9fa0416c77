// SPDX-License-Identifier: Apache-2.0
#include "apps/supplied_boards.hpp"

#include <algorithm>

#include "can_dbc/tables.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {

SuppliedBoards::SuppliedBoards(const EcuOptions& options, const bms::Config& bms, const master::Config& master)
    : bms_{EcuBoard(options, bms, master, {.bms = true, .master = false})},
      master_{EcuBoard(options, bms, master, {.bms = false, .master = true})} {
  for (Unit* unit : {&bms_, &master_}) {
    unit->board.meet();
    const auto [has_bms, has_master] = unit->board.stream().nodes();
    if (unit->board.own_config() || has_bms == has_master) {
      throw InputError("--image " + options.image, "an image with a configuration or a node of its own",
                       "driven_by_plant, which takes each car and both nodes", "Leave --image out");
    }
  }
}

void SuppliedBoards::step(Unit& unit, Instant now, FrameView rx, TxQueue& tx) {
  if (!unit.supply.on(now)) return;
  if (unit.supply.fresh) unit.board.reset();
  unit.supply.fresh = false;
  unit.board.stream().step(now.ms() / static_cast<std::uint32_t>(can::kTickMs), rx,
                           [&tx](Sender, const Frame& frame) { static_cast<void>(tx.push(frame)); });
}

void SuppliedBoards::lose(Sender node) {
  unit_of(node).supply.dead = true;
  unit_of(node).board.kill();
}

void SuppliedBoards::reset(Sender node, Instant now, Duration off) { unit_of(node).supply.fail(now, off); }

void SuppliedBoards::end() {
  for (Unit* unit : {&bms_, &master_}) {
    if (!unit->supply.dead && !unit->board.stream().failed()) unit->board.end();
  }
}

EcuResult SuppliedBoards::result() const {
  const BoardAccount& bms = bms_.board.stream().account();
  const BoardAccount& master = master_.board.stream().account();
  return {.where = bms_.board.options().where,
          .image = bms_.board.image(),
          .board = {.bms = bms.bms,
                    .master = master.master,
                    .both = {},
                    .stack_used = std::max(bms.stack_used, master.stack_used),
                    .stack_size = std::max(bms.stack_size, master.stack_size)}};
}

}  // namespace voltlap::plant
