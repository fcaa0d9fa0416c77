# SPDX-License-Identifier: Apache-2.0
"""Which tests reach a mutant, and whether one of them fails with it."""
import queue
import subprocess
import threading
from concurrent.futures import ThreadPoolExecutor

from mutation.tree import Broken

TIMES_SOUND, LEAST_MS = 10, 500
QUICK_US = 200_000  # a test that takes longer runs with --whole


class Suite:
    """A suite of the copy that serves orders."""

    def __init__(self, program):
        self.process = subprocess.Popen([program, "--serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        start_new_session=True)

    def ask(self, order):
        self.process.stdin.write(order + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline().strip()
        if not answer:
            raise Broken(f"a suite ended while it was asked: {order[:80]}")
        return answer

    def tests(self):
        names = [self.ask("list")]
        while names[-1] != ".":
            names.append(self.process.stdout.readline().strip())
        return names[:-1]

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def record(program, target):
    """[(test, its name, microseconds, mutants reached)] of a sound suite."""
    suite, found = Suite(program), []
    for test, name in enumerate(suite.tests()):
        time, failed, *reached = suite.ask(f"record {test}").split()
        if failed == "1":
            raise Broken(f"{target}: {name} fails without a mutant; a survivor would say nothing")
        found.append((test, name, int(time), {int(mutant) for mutant in reached}))
    suite.close()
    return found


class Trial:
    def __init__(self, tree, targets, given, tell):
        self.programs = {target: tree.build / "tests/bin" / target for target in targets}
        self.jobs, self.tell = given.jobs, tell
        self.most_us = float("inf") if given.whole else QUICK_US

    def record(self):
        with ThreadPoolExecutor(self.jobs) as pool:
            found = pool.map(lambda item: (item[0], record(item[1], item[0])), self.programs.items())
            self.recorded = dict(found)

    def plan(self, mutant, folder):
        """[(suite, tests that reach the mutant, the quick ones first)]: the folder's own suite, then the quick ones."""
        plan = []
        for target, tests in self.recorded.items():
            reached = sorted((time, test) for test, _, time, mutants in tests
                             if mutant in mutants and time <= self.most_us)
            if reached:
                plan.append((f"firmware_{folder}_test" != target, sum(time for time, _ in reached), target,
                             [test for _, test in reached]))
        return sorted(plan)

    def judge(self, suites, mutant, folder):
        """(verdict, the test that saw it)."""
        plan = self.plan(mutant, folder)
        if not plan:
            return "not reached", ""
        for _, time, target, tests in plan:
            if target not in suites:
                suites[target] = Suite(self.programs[target])
            limit = LEAST_MS + TIMES_SOUND * time // 1000
            answer = suites[target].ask(f"run {mutant} {limit} {' '.join(map(str, tests))}").split()
            if answer[0] != "survived":
                name = self.recorded[target][int(answer[1])][1]
                return "killed", name + " does not end" * (answer[0] == "endless")
        return "survived", ""

    def run(self, mutants):
        """{number: (verdict, test)} of [(number, folder)]."""
        waiting, done = queue.SimpleQueue(), {}
        for item in mutants:
            waiting.put(item)
        stop, failures = threading.Event(), []

        def work():
            suites = {}
            try:
                while not stop.is_set() and not waiting.empty():
                    number, folder = waiting.get_nowait()
                    done[number] = self.judge(suites, number, folder)
                    self.tell(len(done), len(mutants))
            except queue.Empty:
                pass
            except Exception as failure:  # pylint: disable=broad-except
                failures.append(failure)
                stop.set()
            finally:
                for suite in suites.values():
                    suite.close()

        workers = [threading.Thread(target=work) for _ in range(self.jobs)]
        try:
            for worker in workers:
                worker.start()
            for worker in workers:
                worker.join()
        finally:
            stop.set()
        if failures:
            raise failures[0]
        return done
