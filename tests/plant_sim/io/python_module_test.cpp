// SPDX-License-Identifier: Apache-2.0
#include "io/python_module.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(PythonModule) {
  Scratch scratch;
  TEST_SETUP() { ::setenv("PYTHONPATH", scratch.file("").c_str(), 1); }
  TEST_TEARDOWN() {
    ::unsetenv("PYTHONPATH");
    ::unsetenv("VOLTLAP_PYTHON");
  }
  void module(const std::string& text) const { scratch.write("told.py", "import os, signal, sys\n" + text); }
  static std::string failure() {
    try {
      (void)run_python_module("told", {});
    } catch (const std::exception& error) {
      return error.what();
    }
    return "no error";
  }
};

TEST(PythonModule, GivesTheOutputForTheArgumentsAsTheyAre) {
  module("print('|'.join(sys.argv[1:]), end='')\n");
  STRCMP_EQUAL("a b|$HOME|\"'|\xC3\xA4", run_python_module("told", {"a b", "$HOME", "\"'", "\xC3\xA4"}).c_str());
}

TEST(PythonModule, MuchOutputAndManyWordsAtOnceDoNotStick) {
  module("for k in range(100):\n  sys.stdout.write('x' * 50000); sys.stderr.write('y' * 50000)\n");
  LONGS_EQUAL(5000000, run_python_module("told", {}).size());
}

TEST(PythonModule, OutputGoesIntoAFileThatIsThereWholeOrNotAtAll) {
  module("print('text', end='')\nsys.exit(int(sys.argv[1]))\n");
  const std::string path = scratch.file("out.txt");
  CHECK_THROWS(std::runtime_error, run_python_module_into(path, "told", {"1"}));
  CHECK_FALSE(std::filesystem::exists(path));
  run_python_module_into(path, "told", {"0"});
  std::ifstream file(path);
  STRCMP_EQUAL("text", std::string(std::istreambuf_iterator<char>(file), {}).c_str());
}

TEST(PythonModule, ExitCodeTwoIsAnInputErrorInTheModulesWords) {
  module("print('a.dbc:3: found x; expected y. Do z.', file=sys.stderr)\nsys.exit(2)\n");
  STRCMP_EQUAL("a.dbc:3: found x; expected y. Do z.", complaint([] { (void)run_python_module("told", {}); }).c_str());
}

TEST(PythonModule, OtherEndsAreTold) {
  module("print('some words', file=sys.stderr)\nsys.exit(7)\n");
  STRCMP_CONTAINS("told ended with exit code 7: some words", failure().c_str());
  module("raise ValueError('of the module')\n");
  STRCMP_CONTAINS("ValueError: of the module", failure().c_str());
  module("os.kill(os.getpid(), signal.SIGKILL)\n");
  STRCMP_CONTAINS("told was ended by signal 9", failure().c_str());
}

TEST(PythonModule, MissingPackageAndMissingPythonAreNamedWithTheCommandThatInstallsThem) {
  module("import a_package_that_nobody_has\n");
  STRCMP_CONTAINS("no Python package 'a_package_that_nobody_has'",
                  complaint([] { (void)run_python_module("told", {}); }).c_str());
  ::setenv("VOLTLAP_PYTHON", "/no/such/python", 1);
  const std::string text = complaint([] { (void)run_python_module("told", {}); });
  STRCMP_CONTAINS("/no/such/python: found no Python", text.c_str());
  STRCMP_CONTAINS("pip install -r", text.c_str());
}

TEST(PythonModule, SignalsAreAsUsualThereAlthoughTheProgramIgnoresThem) {
  module(
      "print(signal.getsignal(signal.SIGINT) == signal.default_int_handler,"
      " os.getpgid(0) == os.getpgid(os.getppid()))\n");
  STRCMP_EQUAL("True True\n", run_python_module("told", {}).c_str());
}
