"""The paper's tests, fault studies, statistics, figures."""
