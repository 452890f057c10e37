# One image for every process of a run; compose.yaml says which process a container is.
FROM python:3.11-slim
WORKDIR /opt/echelon
# Dependencies first: a changed line of ours downloads nothing.
COPY pyproject.toml constraints.txt ./
RUN python -c "import tomllib; p = tomllib.load(open('pyproject.toml', 'rb')); \
print(*p['build-system']['requires'], *p['project']['dependencies'], sep='\n')" > /tmp/dependencies.txt \
    && pip install --no-cache-dir -c constraints.txt -r /tmp/dependencies.txt
COPY README.md ./
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
RUN pip install --no-cache-dir --no-deps --no-build-isolation .
# From here on nothing is imported from the copied folders: the packages are installed.
WORKDIR /tmp
# The solver is compiled here, and again only when its own text changes: the cache of the build keeps it, the image holds
# this one alone. Containers copy it to their /tmp, because their root is read-only.
ENV ECHELON_PREBUILT=/opt/kernels ECHELON_CACHE=/tmp OPENBLAS_NUM_THREADS=1 PYTHONUNBUFFERED=1
RUN --mount=type=cache,target=/kernels \
    ECHELON_CACHE=/kernels python -c "from runtime.precompile import ensure_compiled; ensure_compiled(print)" \
    && ECHELON_PREBUILT=/kernels ECHELON_CACHE=/opt/kernels \
    python -c "from agents.kernels.jit_cache import fetch_prebuilt; fetch_prebuilt()" \
    && chmod -R a+rX /opt/kernels
RUN mkdir /records /var/lib/echelon /keys && chown 10001:10001 /records /var/lib/echelon /keys && chmod 700 /keys
USER 10001:10001
