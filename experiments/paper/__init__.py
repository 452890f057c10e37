"""The paper's tests of section 4, chapter by chapter, in one report."""
