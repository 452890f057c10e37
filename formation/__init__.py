"""The task, pure: paths, formations, errors, faults and scenario files. It reads no clock, socket or global."""
