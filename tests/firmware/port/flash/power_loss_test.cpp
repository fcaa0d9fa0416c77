// SPDX-License-Identifier: Apache-2.0
// A BMS that drives, trips, is reset and loses its supply, with what it keeps in flash: the supply is cut at every unit
// that it programs and every area that it erases, in every way that a unit can be left, and the BMS starts anew. All of
// the trips' units; of the others a drawn part, and all with VOLTLAP_TEST_WHOLE=1, a few minutes.
// BMS-025, BMS-083
#include <cstdlib>
#include <cstring>
#include <random>

#include "app/bms_node.hpp"
#include "examples/bms_memory.hpp"
#include "fake_flash.hpp"
#include "bms/bench.hpp"
#include "bms/faults.hpp"
#include "bms/estimate/filter_bench.hpp"
#include "port/flash/flash_nvm.hpp"

using namespace voltlap;
using namespace voltlap::port;
using bms::test::Bench;
using test::Cut;
using test::FakeFlash;

namespace {

constexpr std::size_t kArea = 64 * 1024;
constexpr std::size_t kAhead = 35;  // records of charge that a drive writes: every start but the first moves
constexpr std::uint64_t kSeed = 20'161;

struct Counts {
  std::uint64_t cuts = 0, trips_before = 0, trips_after = 0, trips_unknown = 0;
  std::uint64_t soc_before = 0, soc_after = 0, soc_none = 0;
};

/// The last records that were whole, and the one that is being written.
struct Written {
  bool trip_whole = false, soc_whole = false;
  bms::TripSlot trip{}, trip_next{};
  bms::SocSlot soc{}, soc_next{};
  bool soc_under_way = false;
};

bool same(const bms::SocSlot& a, const bms::SocSlot& b) { return std::memcmp(a.bytes, b.bytes, sizeof a.bytes) == 0; }
std::uint32_t latched_in(const bms::TripSlot& slot) {
  const bms::TripSlot both[2] = {slot, slot};
  return bms::read_slots(both).newest.latched;
}

/// A memory that, before it does what it is told, loses its supply in the midst of that in every way there is.
class CutNvm final : public Nvm {
 public:
  CutNvm(FakeFlash& flash, const bms::Config& config, Counts& counts, Written& written, std::mt19937_64& draw)
      : flash_(flash), config_(config), counts_(counts), written_(written), draw_(draw), nvm_(flash, kAhead) {}

  bool prepare() override {
    cut_everywhere(whole_ ? 1 : 7, [](FlashNvm& nvm) {
      nvm.prepare();
      return NvmResult::kOk;
    });
    return nvm_.prepare();
  }
  void read(NvmRecord record, std::size_t slot, std::uint8_t* bytes, std::size_t count) override {
    nvm_.read(record, slot, bytes, count);
  }
  NvmResult write(NvmRecord record, std::size_t slot, const std::uint8_t* bytes, std::size_t count) override {
    const bool trip = record == NvmRecord::kTrips;
    std::memcpy(trip ? written_.trip_next.bytes : written_.soc_next.bytes, bytes, count);
    written_.soc_under_way = written_.soc_under_way || !trip;
    cut_everywhere(1, [&](FlashNvm& nvm) { return nvm.write(record, slot, bytes, count); });
    const NvmResult result = nvm_.write(record, slot, bytes, count);
    CHECK(result == NvmResult::kOk);
    if (trip) {
      written_.trip = written_.trip_next;
      written_.trip_whole = true;
    }
    return result;
  }
  NvmResult step() override {
    cut_everywhere(whole_ ? 1 : 61, [](FlashNvm& nvm) { return nvm.step(); });
    const NvmResult result = nvm_.step();
    if (result == NvmResult::kOk && written_.soc_under_way) {
      written_.soc = written_.soc_next;
      written_.soc_whole = true;
      written_.soc_under_way = false;
    }
    return result;
  }

 private:
  /// One in `share` of the units, drawn, and the one that makes the record whole.
  template <class Call>
  void cut_everywhere(std::uint64_t share, const Call& call) {
    const FakeFlash saved = flash_;
    FlashNvm dry(nvm_);
    const bool whole_at_end = call(dry) == NvmResult::kOk;
    const std::uint64_t end = flash_.operations;
    flash_ = saved;
    for (std::uint64_t at = saved.operations; at < end; ++at) {
      const bool last = whole_at_end && at + 1 == end;
      if (!last && share > 1 && draw_() % share != 0) continue;
      for (int how = 0; how < test::kCuts; ++how) {
        flash_.cut_at = at;
        flash_.cut = static_cast<Cut>(how);
        FlashNvm victim(nvm_);
        bool lost = false;
        try {
          static_cast<void>(call(victim));
        } catch (const stm32::test::PowerLost&) {
          lost = true;
        }
        CHECK(lost);
        flash_.cut_at = UINT64_MAX;
        ++counts_.cuts;
        start_anew();
        flash_ = saved;
      }
    }
  }

  /// What a BMS makes of the memory as the cut has left it.
  void start_anew() {
    FlashNvm nvm(flash_, kAhead);
    static app::BmsNode node(config_);
    node = app::BmsNode(config_);
    examples::BmsMemory(nvm).restore(node);
    check_trips(node.state().faults.latched);
    bms::SocSlot slots[bms::kSocSlots];
    for (std::size_t i = 0; i < bms::kSocSlots; ++i) {
      nvm.read(NvmRecord::kSoc, i, slots[i].bytes, sizeof slots[i].bytes);
    }
    check_soc(slots);
    CHECK(!flash_.programmed_twice);
  }
  void check_trips(std::uint32_t latched) {
    const std::uint32_t before = written_.trip_whole ? latched_in(written_.trip) : 0;
    if (latched == before) {
      ++counts_.trips_before;
    } else if (latched == latched_in(written_.trip_next)) {
      ++counts_.trips_after;
    } else {  // only the very first may be unknown, and then it says so
      CHECK(!written_.trip_whole);
      LONGS_EQUAL(bms::bit_of(can::BmsFault::kConfigInvalid), latched);
      ++counts_.trips_unknown;
    }
  }
  void check_soc(const bms::SocSlot (&slots)[bms::kSocSlots]) {
    bms::SocRecord newest;
    std::size_t oldest = 0;
    bms::read_slots(slots, newest, oldest);
    if (newest.cells == 0) {
      CHECK(!written_.soc_whole);
      ++counts_.soc_none;
      return;
    }
    const bms::SocSlot& found = slots[1 - oldest];
    const bool before = written_.soc_whole && same(found, written_.soc);
    CHECK(before || (written_.soc_under_way && same(found, written_.soc_next)));
    (before ? counts_.soc_before : counts_.soc_after)++;
  }

  FakeFlash& flash_;
  const bms::Config& config_;
  Counts& counts_;
  Written& written_;
  std::mt19937_64& draw_;
  FlashNvm nvm_;
  const bool whole_ = std::getenv("VOLTLAP_TEST_WHOLE") != nullptr;
};

/// A start of the BMS and a minute of driving; twice a cell falls too low, and the trip is reset.
void drive(CutNvm& nvm, const bms::Config& config, bms::test::TrueCell& cell) {
  Bench bench(config);
  app::BmsNode node(config);
  examples::BmsMemory memory(nvm);
  TxQueue tx;
  memory.restore(node);
  for (int tick = 0; tick < 6000; ++tick) {
    const int second = tick / 100;
    const bool low = second == 15 || second == 40;
    const bool rests = second < 1 || (second >= 15 && second < 25) || (second >= 40 && second < 50);
    const double amperes = rests ? 0.0 : 100.0;
    cell.advance(amperes, 0.01);
    bench.cells(low ? 23'000 : static_cast<std::int32_t>(1e4 * cell.voltage(config)));
    bench.current(bms::test::amps(amperes));
    bench.master.reset_request = second == 20 || second == 45;
    const Instant now = bench.now();
    bench.tick();
    tx.clear();
    node.tick(now, bench.sent(), tx);
    memory.keep(node);
  }
}

}  // namespace

TEST_GROUP(PowerLoss) {
  static std::uint64_t seed() {
    const char* given = std::getenv("VOLTLAP_TEST_SEED");
    return given != nullptr ? std::strtoull(given, nullptr, 10) : kSeed;
  }
  static Counts lose_power(std::size_t unit) {
    std::printf("VOLTLAP_TEST_SEED=%llu\n", static_cast<unsigned long long>(seed()));
    std::mt19937_64 draw(seed());
    FakeFlash flash(unit, kArea, unit == 8);
    flash.draw = &draw;
    bms::Config config = bms::test::filtered_config();
    config.soc_method = bms::SocMethod::kCoulomb;
    bms::test::TrueCell cell;
    Counts counts;
    Written written;
    for (int start = 0; start < 3; ++start) {
      CutNvm nvm(flash, config, counts, written, draw);
      drive(nvm, config, cell);
    }
    std::printf("units of %zu B: %llu cuts; trips: %llu before, %llu after, %llu unknown; charge: %llu before, "
                "%llu after, %llu none; %llu areas erased\n", unit, static_cast<unsigned long long>(counts.cuts),
                static_cast<unsigned long long>(counts.trips_before),
                static_cast<unsigned long long>(counts.trips_after),
                static_cast<unsigned long long>(counts.trips_unknown),
                static_cast<unsigned long long>(counts.soc_before), static_cast<unsigned long long>(counts.soc_after),
                static_cast<unsigned long long>(counts.soc_none), static_cast<unsigned long long>(flash.erasures));
    return counts;
  }
};

TEST(PowerLoss, ABmsStartsWithARecordThatWasOnceValidOrSaysThatItHasNoneOnWords) {
  const Counts counts = lose_power(4);
  CHECK(counts.cuts > 2'000 && counts.trips_before > 0 && counts.trips_after > 0 && counts.trips_unknown > 0);
  CHECK(counts.soc_before > 0 && counts.soc_after > 0 && counts.soc_none > 0);
}

TEST(PowerLoss, ABmsStartsWithARecordThatWasOnceValidOrSaysThatItHasNoneOnDoubleWordsWithEcc) {
  const Counts counts = lose_power(8);
  CHECK(counts.cuts > 1'000 && counts.trips_before > 0 && counts.trips_after > 0 && counts.trips_unknown > 0);
  CHECK(counts.soc_before > 0 && counts.soc_after > 0 && counts.soc_none > 0);
}
