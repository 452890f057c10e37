"""Other hosts in a run: its authority, codes for those who may join, enrolment and what a host that joined runs."""
