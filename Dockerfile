# One image for every process of a run; compose.yaml says which process a container is.
FROM python:3.11-slim
WORKDIR /opt/echelon
COPY pyproject.toml constraints.txt README.md ./
COPY formation formation
COPY network network
COPY agents agents
COPY world world
COPY records records
COPY ros ros
COPY dashboard dashboard
COPY runtime runtime
COPY experiments experiments
COPY api api
COPY cli cli
COPY echelon.py echelon.py
COPY echelon-stubs echelon-stubs
COPY scenarios scenarios
COPY studies studies
RUN pip install --no-cache-dir -c constraints.txt .
# From here on nothing is imported from the copied folders: the packages are installed.
WORKDIR /tmp
# The solver is compiled here, once; containers copy it to their /tmp, because their root is read-only.
ENV ECHELON_PREBUILT=/opt/kernels ECHELON_CACHE=/tmp OPENBLAS_NUM_THREADS=1 PYTHONUNBUFFERED=1
RUN ECHELON_CACHE=/opt/kernels python -c "from runtime.precompile import ensure_compiled; ensure_compiled(print)"
RUN mkdir /records && chown 10001:10001 /records
USER 10001:10001
