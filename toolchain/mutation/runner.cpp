// SPDX-License-Identifier: Apache-2.0
// The main function of a suite in the mutated copy. With --serve it takes orders on its standard input, one a line, and
// answers each with a line; every order runs in a child process, so that a mutant leaves nothing behind.
//   list                    names of the tests, one a line, then "."
//   record TEST             microseconds, 1 when it failed, and the mutants that were reached
//   run MUTANT MS TEST...   "survived", "killed TEST" or "endless TEST": the first test that fails ends it
// Else the tests run as ever, with the mutant of the environment variable VOLTLAP_MUTANT.
#include <CppUTest/CommandLineTestRunner.h>
#include <CppUTest/MemoryLeakWarningPlugin.h>
#include <CppUTest/TestOutput.h>
#include <CppUTest/TestPlugin.h>
#include <CppUTest/TestRegistry.h>
#include <CppUTest/TestResult.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

int voltlap_mutant_on = -1;
unsigned char voltlap_mutants_reached[VOLTLAP_MUTANTS] = {};

namespace {

constexpr int kFailed = 1;
constexpr rlim_t kMemory = rlim_t{4} << 30U;

class FirstFailureEnds : public TestResult {
 public:
  using TestResult::TestResult;
  void addFailure(const TestFailure& /*failure*/) override { _exit(kFailed); }
};

struct Shared {
  int test;
  unsigned char reached[VOLTLAP_MUTANTS];
};

std::vector<UtestShell*> all_tests() {
  std::vector<UtestShell*> tests;
  for (UtestShell* test = TestRegistry::getCurrentRegistry()->getFirstTest(); test != nullptr; test = test->getNext()) {
    tests.push_back(test);
  }
  return tests;
}

[[noreturn]] void run_in_child(const std::vector<UtestShell*>& tests, const std::vector<int>& wanted, Shared& shared) {
  const int nowhere = open("/dev/null", O_RDWR);
  for (int fd : {0, 1, 2}) dup2(nowhere, fd);
  StringBufferTestOutput output;
  FirstFailureEnds result(output);
  NullTestPlugin plugin;
  for (const int index : wanted) {
    shared.test = index;
    tests[static_cast<std::size_t>(index)]->runOneTest(&plugin, result);
  }
  for (int i = 0; i < VOLTLAP_MUTANTS; ++i) shared.reached[i] = voltlap_mutants_reached[i];
  _exit(0);
}

int run(const std::vector<UtestShell*>& tests, const std::vector<int>& wanted, int mutant, long ms, Shared& shared) {
  std::cout.flush();
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGALRM, SIG_DFL);
    itimerval limit{};
    limit.it_value.tv_sec = ms / 1000;
    limit.it_value.tv_usec = ms % 1000 * 1000;
    setitimer(ITIMER_REAL, &limit, nullptr);
    const rlimit memory{kMemory, kMemory}, no_core{0, 0};
    setrlimit(RLIMIT_AS, &memory);
    setrlimit(RLIMIT_CORE, &no_core);
    voltlap_mutant_on = mutant;
    run_in_child(tests, wanted, shared);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

void record(const std::vector<UtestShell*>& tests, int test, Shared& shared) {
  for (unsigned char& reached : shared.reached) reached = 0;
  const auto begin = std::chrono::steady_clock::now();
  const int status = run(tests, {test}, -1, 600'000, shared);
  const auto time = std::chrono::steady_clock::now() - begin;
  std::cout << std::chrono::duration_cast<std::chrono::microseconds>(time).count() << ' ' << (status != 0);
  for (int i = 0; i < VOLTLAP_MUTANTS; ++i) {
    if (shared.reached[i] != 0) std::cout << ' ' << i;
  }
  std::cout << std::endl;
}

void serve() {
  auto* shared = static_cast<Shared*>(
      mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  const std::vector<UtestShell*> tests = all_tests();
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string order;
    words >> order;
    if (order == "list") {
      for (UtestShell* test : tests) {
        std::cout << test->getGroup().asCharString() << '.' << test->getName().asCharString() << '\n';
      }
      std::cout << '.' << std::endl;
    } else if (order == "record") {
      int test = 0;
      words >> test;
      record(tests, test, *shared);
    } else {
      int mutant = 0;
      long ms = 0;
      words >> mutant >> ms;
      std::vector<int> wanted;
      for (int test; words >> test;) wanted.push_back(test);
      const int status = run(tests, wanted, mutant, ms, *shared);
      if (status == 0) std::cout << "survived" << std::endl;
      else std::cout << (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM ? "endless " : "killed ") << shared->test
                     << std::endl;
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  MemoryLeakWarningPlugin::turnOffNewDeleteOverloads();
  if (argc == 2 && std::string(argv[1]) == "--serve") {
    serve();
    return 0;
  }
  if (const char* mutant = std::getenv("VOLTLAP_MUTANT")) voltlap_mutant_on = std::atoi(mutant);
  return CommandLineTestRunner::RunAllTests(argc, argv);
}
