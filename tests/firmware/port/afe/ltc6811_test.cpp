// SPDX-License-Identifier: Apache-2.0
#include "port/afe/ltc6811.hpp"

#include <cmath>
#include <cstdlib>
#include <random>

#include "app/bms_node.hpp"
#include "app/cell_monitor.hpp"
#include "bms/bench.hpp"
#include "fake_chain.hpp"
#include "port/afe/pec15.hpp"

using namespace voltlap;
using namespace voltlap::port::afe;
using test::FakeChain;

namespace {

std::uint64_t seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? std::strtoull(given, nullptr, 10) : 6'811;
}

}  // namespace

TEST_GROUP(Ltc6811) {
  static constexpr std::size_t kCells = 24, kSensors = 6;
  FakeChain fake{2};
  Ltc6811Chain::Config config;
  void setup() override {
    config.chips = 2;
    config.chip[0] = config.chip[1] = {12, 3};
    for (std::size_t i = 0; i < kCells; ++i) fake.chip[i / 12].cell[i % 12] = cell_of(i);
    for (auto& chip : fake.chip) {
      for (auto& input : chip.input) input = 15'000;  // half of the reference: 25 degC
    }
  }
  static std::uint16_t cell_of(std::size_t i) { return static_cast<std::uint16_t>(38'000 + 17 * i); }

  struct Read {
    std::int32_t value[24] = {};
    bool ok[24] = {};
    bool fresh = true;
  };
  static Read cells(Ltc6811Chain& chain) {
    Read out;
    for (std::uint8_t g = 0; g < 8; ++g) {
      can::CellVoltages m;
      m.group = g;
      out.fresh = chain.take(m) && out.fresh;
      for (std::size_t i = 0; i < 3; ++i) {
        out.value[3 * g + i] = m.cell_100uv[i];
        out.ok[3 * g + i] = m.cell_ok[i];
      }
    }
    return out;
  }
  static void run(Ltc6811Chain& chain, int ticks) {
    for (int i = 0; i < ticks; ++i) chain.step();
  }
};

TEST(Ltc6811, ThePecIsTheDatasheetsExampleAndThatOfTheFake) {
  const std::uint8_t example[] = {0x00, 0x01};  // "PEC calculation": WRCFGA, 0x3D6E
  UNSIGNED_LONGS_EQUAL(0x3D6E, pec15(example, 2));
  std::mt19937_64 draw(seed());
  for (int i = 0; i < 500; ++i) {
    std::uint8_t bytes[6];
    for (auto& b : bytes) b = static_cast<std::uint8_t>(draw());
    UNSIGNED_LONGS_EQUAL(FakeChain::crc(bytes, 6), pec15(bytes, 6));
  }
}

TEST(Ltc6811, EveryCellIsReadAtItsPlaceWithinTwoTicks) {
  Ltc6811Chain chain(fake, config);
  CHECK(chain.init());
  chain.step();
  CHECK(!cells(chain).fresh);
  chain.step();
  const Read read = cells(chain);
  CHECK(read.fresh);
  for (std::size_t i = 0; i < kCells; ++i) {
    LONGS_EQUAL(cell_of(i), read.value[i]);
    CHECK(read.ok[i]);
  }
  CHECK(!cells(chain).fresh);  // taken once
  LONGS_EQUAL(0, fake.refused);
}

TEST(Ltc6811, ThermistorsAreReadByTheTableAndAnOpenOrShortedOneIsNot) {
  fake.chip[0].input[1] = 29'990;  // open: the reference
  fake.chip[1].input[0] = 5;       // shorted
  fake.chip[1].input[2] = 6'000;
  Ltc6811Chain chain(fake, config);
  CHECK(chain.init());
  run(chain, 3);
  can::Temperatures first, second;
  second.group = 1;
  CHECK(chain.take(first) && chain.take(second));
  LONGS_EQUAL(250, first.temperature_dc[0]);
  CHECK(first.temperature_ok[0] && !first.temperature_ok[1] && first.temperature_ok[2]);
  CHECK(!second.temperature_ok[0] && second.temperature_ok[2]);
  DOUBLES_EQUAL(596, second.temperature_dc[2], 3);  // a fifth of the reference: 2.5 kOhm
}

TEST(Ltc6811, AReferenceThatIsNotThreeVoltsMakesNoTemperature) {
  fake.chip[0].reference = 24'000;
  Ltc6811Chain chain(fake, config);
  CHECK(chain.init());
  run(chain, 3);
  can::Temperatures first;
  CHECK(chain.take(first));
  CHECK(!first.temperature_ok[0] && !first.temperature_ok[2]);
}

TEST(Ltc6811, TheTableIsTheThermistorsEquation) {
  double worst = 0.0;
  for (double t = -39.5; t < 120.0; t += 0.37) {
    const double r = 10e3 * std::exp(3977.0 * (1.0 / (t + 273.15) - 1.0 / 298.15));
    std::int32_t got = 0;
    CHECK(temperature_of(kNtc10k3977, static_cast<std::uint32_t>(std::lround(65536.0 * r / (r + 10e3))), got));
    worst = std::max(worst, std::abs(0.1 * got - t));
  }
  std::printf("thermistor table: %.2f K off at most (bound 0.3 K)\n", worst);
  CHECK(worst < 0.3);
}

TEST(Ltc6811, AnyFlippedBitOnTheWayIsSeenCountedAndTheGroupOfThatChipNotBelieved) {
  std::printf("VOLTLAP_TEST_SEED=%llu\n", static_cast<unsigned long long>(seed()));
  std::mt19937_64 draw(seed());
  Ltc6811Chain chain(fake, config);
  CHECK(chain.init());
  std::uint32_t flips = 0, bad_cells = 0;
  for (int round = 0; round < 3000; ++round) {
    fake.disturb = [](auto&) {};
    const std::uint32_t before = chain.counts().pec_errors;
    bool flipped = false;
    fake.disturb = [&](std::vector<std::uint8_t>& bytes) {
      if (bytes.empty() || flipped || draw() % 4 != 0) return;
      const int many = 1 + static_cast<int>(draw() % 3);  // up to three: a CRC of 15 bits sees them all here
      const std::size_t chip = draw() % 2;
      std::set<std::size_t> bits;
      while (bits.size() < static_cast<std::size_t>(many)) bits.insert(draw() % 64);
      for (const std::size_t b : bits) bytes[8 * chip + b / 8] ^= static_cast<std::uint8_t>(1U << (b % 8));
      flipped = true;
    };
    chain.step();
    LONGS_EQUAL(flipped ? 1 : 0, chain.counts().pec_errors - before);
    flips += flipped ? 1 : 0;
    const Read read = cells(chain);
    for (std::size_t i = 0; i < kCells && read.fresh; ++i) {
      if (read.ok[i]) LONGS_EQUAL(cell_of(i), read.value[i]);
      bad_cells += read.ok[i] ? 0 : 1;
    }
  }
  std::printf("%u damaged answers, %u readings not believed, none wrong\n", flips, bad_cells);
  CHECK(flips > 500 && bad_cells > 500);
}

TEST(Ltc6811, AChipThatDoesNotAnswerTakesItsCellsAndThoseBehindItAndComesBack) {
  Ltc6811Chain chain(fake, config);
  CHECK(chain.init());
  run(chain, 30);
  fake.chip[1].answers = false;
  run(chain, 30);
  Read read = cells(chain);
  for (std::size_t i = 0; i < kCells; ++i) CHECK_EQUAL(i < 12, read.ok[i]);
  fake.chip[0].answers = false;
  run(chain, 30);
  read = cells(chain);
  for (std::size_t i = 0; i < kCells; ++i) CHECK(!read.ok[i]);
  fake.chip[0].answers = fake.chip[1].answers = true;
  fake.chip[1].start();  // it lost its supply
  run(chain, 30);
  read = cells(chain);
  for (std::size_t i = 0; i < kCells; ++i) CHECK(read.ok[i]);
  CHECK(chain.counts().config_errors > 0);
  CHECK(chain.counts().pec_errors > 0);
}

TEST(Ltc6811, AConversionThatNeverHappenedIsNoOldReading) {
  Ltc6811Chain chain(fake, config);
  CHECK(chain.init());
  run(chain, 2);
  CHECK(cells(chain).ok[0]);
  chain.step();
  run(chain, 5);  // over the check of the wires
  for (auto& c : fake.chip) {
    for (auto& v : c.cell) v = 0xFFFF;  // what the registers hold when nothing was converted
  }
  run(chain, 30);
  const Read read = cells(chain);
  for (std::size_t i = 0; i < kCells; ++i) CHECK(!read.ok[i]);
}

TEST(Ltc6811, AWireThatIsOffIsFoundAtEveryPinWithinOneAndAHalfSecondsAndItsCellsAreNotBelieved) {
  int slowest = 0;
  for (std::size_t chip_off = 0; chip_off < 2; ++chip_off) {
    for (int pin = 0; pin <= 12; ++pin) {
      FakeChain broken = fake;
      Ltc6811Chain chain(broken, config);
      CHECK(chain.init());
      run(chain, 45 + 7 * pin);
      for (std::size_t c = 0; c < 2; ++c) {
        for (std::size_t p = 0; p <= 12; ++p) CHECK(!chain.wire_is_off(c, p));
      }
      broken.chip[chip_off].wires_off = {pin};
      int ticks = 0;
      while (!chain.wire_is_off(chip_off, static_cast<std::size_t>(pin)) && ticks < 400) {
        chain.step();
        ++ticks;
      }
      slowest = std::max(slowest, ticks);
      run(chain, 3);
      const Read read = cells(chain);
      for (std::size_t c = 0; c < 2; ++c) {
        for (int p = 0; p <= 12; ++p) {
          CHECK_EQUAL(c == chip_off && p == pin, chain.wire_is_off(c, static_cast<std::size_t>(p)));
        }
      }
      for (int i = 0; i < 24; ++i) {
        const bool touches = static_cast<std::size_t>(i / 12) == chip_off && (i % 12 == pin || i % 12 + 1 == pin);
        CHECK_EQUAL(!touches, read.ok[i]);
      }
      broken.chip[chip_off].wires_off.clear();
      run(chain, 150);
      CHECK(cells(chain).ok[12 * chip_off]);
    }
  }
  bms::test::expect_time("AFE: a wire off, found", 10 * slowest, 0, 1'500);
}

TEST(Ltc6811, ShuntsFollowWithinARoundAndFallOffWhenNobodyAsksForThem) {
  Ltc6811Chain chain(fake, config);
  CHECK(chain.init());
  run(chain, 20);
  const std::uint32_t words[] = {1U << 0 | 1U << 11 | 1U << 12 | 1U << 23};
  chain.bleed(words, 1);
  run(chain, 9);
  UNSIGNED_LONGS_EQUAL(1U << 0 | 1U << 11, fake.chip[0].shunts());
  UNSIGNED_LONGS_EQUAL(1U << 0 | 1U << 11, fake.chip[1].shunts());
  run(chain, 40);
  CHECK(fake.chip[0].shunts() != 0);
  run(chain, 2);
  UNSIGNED_LONGS_EQUAL(0, fake.chip[0].shunts() | fake.chip[1].shunts());
}

TEST(Ltc6811, AnImpossibleConfigurationIsRefusedAndMeasuresNothing) {
  config.chip[1].cells = 13;
  Ltc6811Chain chain(fake, config);
  CHECK(!chain.init());
  run(chain, 10);
  LONGS_EQUAL(0, fake.exchanges);
  config.chips = 13;
  CHECK(!Ltc6811Chain(fake, config).init());
  config.chips = 0;
  CHECK(!Ltc6811Chain(fake, config).init());
}

TEST(Ltc6811, ATickMovesABoundedNumberOfBytes) {
  config.chips = 12;
  for (auto& chip : config.chip) chip = {12, 3};
  FakeChain long_chain(12);
  Ltc6811Chain chain(long_chain, config);
  CHECK(chain.init());
  std::uint32_t most = 0;
  for (int i = 0; i < 200; ++i) {
    const std::uint32_t before = long_chain.bytes;
    chain.step();
    most = std::max(most, long_chain.bytes - before);
  }
  std::printf("144 cells: %u bytes in a tick at most, %.1f ms of SPI at 1 MHz\n", most, most * 8e-3);
  CHECK(most <= 500);
}

namespace {

/// A BMS that is fed by the chain in the place of the monitors' frames, beside one that hears those.
struct Fed {
  Fed(FakeChain& fake, const Ltc6811Chain::Config& config) : chain(fake, config), node(bench.config) {
    CHECK(chain.init());
  }
  /// The frames of the bench without its monitors', and those of the chain.
  void tick(TxQueue& tx) {
    const Instant now = bench.now();
    bench.tick();
    std::vector<Frame> frames;
    for (const Frame& f : bench.sent()) {
      if (f.id < 0x200 || f.id > 0x24B) frames.push_back(f);
    }
    chain.step();
    Frame own[app::CellMonitor::kFramesMax];
    const std::size_t count = monitor.frames(now, chain, own);
    frames.insert(frames.end(), own, own + count);
    tx.clear();
    node.tick(now, {frames.data(), frames.size()}, tx);
  }
  bms::test::Bench bench;
  Ltc6811Chain chain;
  app::CellMonitor monitor{24, 6};
  app::BmsNode node;
};

}  // namespace

TEST(Ltc6811, ABmsFedByTheChainDrivesAndTripsAsOneThatIsFedByFrames) {
  for (auto& chip : fake.chip) {
    for (auto& cell : chip.cell) cell = 39'000;
  }
  Fed fed(fake, config);
  TxQueue tx;
  for (int i = 0; i < 100; ++i) fed.tick(tx);
  LONGS_EQUAL(0, fed.node.output().faults);
  CHECK(fed.node.output().state == can::BmsState::kIdle);
  CHECK(fed.node.state().pack.cells_good && fed.node.state().pack.temperatures_good);
  fed.bench.request(true);
  for (int i = 0; i < 300; ++i) fed.tick(tx);
  CHECK(fed.node.output().state == can::BmsState::kTsActive);
  fake.chip[1].wires_off = {5};
  int ticks = 0;
  while (fed.node.output().state == can::BmsState::kTsActive && ticks < 1000) {
    fed.tick(tx);
    ++ticks;
  }
  CHECK(bms::test::all_open(fed.node.output()));
  bms::test::expect_time("AFE: a wire off opens the contactors", 10 * ticks, 0, 2'500);
}
