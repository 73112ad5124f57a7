"""The results of the test cases of a program, as ctest and rostest read them. A module of tests."""
import time
import unittest
from xml.etree import ElementTree


class Results(unittest.TextTestResult):
    """Writes down each case as gtest does; rosunit's own runner would count a skipped one as passed."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.suite = ElementTree.Element('testsuite')
        self.case = None

    def startTest(self, test):
        super().startTest(test)
        self.started = time.monotonic()
        self.case = ElementTree.SubElement(self.suite, 'testcase', name=test._testMethodName,
                                           classname=type(test).__name__)

    def note(self, kind, text):
        if self.case is None:  # setUpClass failed, and no case was run
            self.case = ElementTree.SubElement(self.suite, 'testcase', name='setUpClass')
        note = ElementTree.SubElement(self.case, kind, message=text.strip().splitlines()[-1], type=kind)
        # Control characters, such as colours, are not XML.
        note.text = ''.join(letter for letter in text if letter >= ' ' or letter == '\n')

    def stopTest(self, test):
        self.case.set('time', '%.3f' % (time.monotonic() - self.started))
        self.case = None
        super().stopTest(test)

    def addError(self, test, error):
        super().addError(test, error)
        self.note('error', self.errors[-1][1])

    def addFailure(self, test, error):
        super().addFailure(test, error)
        self.note('failure', self.failures[-1][1])

    def addSubTest(self, test, part, error):
        super().addSubTest(test, part, error)
        if error is not None:
            self.note('failure', '%s: %s' % (part, error[1]))

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        self.note('skipped', reason)
