// SPDX-License-Identifier: Apache-2.0
#include "replay/shadow_words.hpp"

#include "core/errors.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

Disagreement current_of(double begin_s, double weight, const char* what) {
  return {weight, begin_s, begin_s + 1.0, what, ""};
}

ReplayResult with(std::vector<Disagreement> disagreements) {
  ReplayResult out;
  out.disagreements = std::move(disagreements);
  return out;
}

}  // namespace

TEST_GROUP(ShadowWords) { NewDisagreements news; };

TEST(ShadowWords, ADisagreementIsSaidOnceAndAgainWhenItIsWorseElsewhere) {
  LONGS_EQUAL(1, news.of(with({current_of(10.0, 201.0, "120 A of discharge at 10.2 s (cell voltage)")})).size());
  LONGS_EQUAL(0, news.of(with({current_of(10.0, 201.0, "120 A of discharge at 10.2 s (cell voltage)")})).size());
  // The same stretch a little worse, then another one that is less, then one that is worse.
  LONGS_EQUAL(0, news.of(with({current_of(10.0, 203.0, "140 A of discharge at 10.4 s (cell voltage)")})).size());
  LONGS_EQUAL(0, news.of(with({current_of(30.0, 200.5, "110 A of discharge at 30.4 s (SOC)")})).size());
  LONGS_EQUAL(1, news.of(with({current_of(40.0, 210.0, "210 A of discharge at 40.4 s (SOC)")})).size());
}

TEST(ShadowWords, AnotherKindIsNewWhereverItIs) {
  const Disagreement one = current_of(10.0, 201.0, "120 A of discharge at 10.2 s"),
                     other = current_of(10.0, 201.0, "120 A of charge at 10.2 s");
  LONGS_EQUAL(1, news.of(with({one})).size());
  const auto found = news.of(with({one, other}));
  LONGS_EQUAL(1, found.size());
  STRCMP_EQUAL(other.what.c_str(), found[0].what.c_str());
}

TEST(ShadowWords, WhatIsWaitedForIsWhatTheErrorFound) {
  const InputError error("heard.log", "no current", "the role current", "Nothing without it");
  STRCMP_EQUAL("no current", waiting_text(error.what()).c_str());
  STRCMP_EQUAL("something else", waiting_text("something else").c_str());
}

TEST(ShadowWords, TheStatusHasTheFirmwaresWordBesideTheCarsOwn) {
  ReplayResult result;
  result.pack = "pack.toml";
  ReplayRow row;
  STRCMP_EQUAL("the firmware has only just begun", status_text(result).c_str());
  row.state = can::BmsState::kTsActive;
  row.soc = 0.801;
  row.logged_soc = 0.83;
  row.discharge_limit_a = 235.0;
  row.discharge_reason = can::LimitReason::kCellVoltage;
  row.limiting_cell = 31;
  row.charge_limit_a = 60.0;
  row.logged_charge_limit_a = 40.0;
  result.rows.push_back(row);
  result.rows.emplace_back();  // of a moment in which it says nothing
  STRCMP_EQUAL("SOC 80.1 % (the car's unit 83.0 %) | discharge 235 A, cell voltage of cell 31 | charge 60 A, no limit "
               "(the car's unit 40.0 A) | faults none", status_text(result).c_str());
  result.pack.clear();
  STRCMP_EQUAL("no cell model (--pack) | faults none", status_text(result).c_str());
  result.never_ready = "it waits for Cells";
  STRCMP_CONTAINS("has not closed its contactors: it waits for Cells", status_text(result).c_str());
}
