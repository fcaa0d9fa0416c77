// SPDX-License-Identifier: Apache-2.0
// The temperature at which the tables are read: the model's own course, and slowly what the thermistors say. Steps and
// noise of a thermistor would come back as errors of the resistances.
#pragma once
#include "explain/model/observed.hpp"

namespace voltlap::explain {

/// Mean of the thermistors where their steps are taken away; empty where none had any, or little is known then.
[[nodiscard]] VectorXd without_steps(const plant::Recording& log);
/// Temperature of the cells by the course of a model, and by how much they are warmer inside.
void settle_temperature(const plant::World& model, const Observed& log, plant::LogFacts& facts);
/// The facts of a log where another world is believed: one with more heat begins and ends at another temperature.
[[nodiscard]] plant::LogFacts facts_with(const plant::World& world, const Observed& log);

}  // namespace voltlap::explain
