# Builds the Debian package and installs it into a small image:
#   docker build -t mscomp .
#   docker run --rm -v "$PWD:/data" mscomp acapfeat check meshes
FROM debian:12-slim AS build
WORKDIR /source
COPY scripts/setup.sh scripts/
RUN scripts/setup.sh --package
COPY . .
RUN cmake --preset release -DBUILD_TESTING=OFF \
    && cmake --build --preset release \
    && cpack --config build/release/CPackConfig.cmake -G DEB -B /packages

FROM debian:12-slim
COPY --from=build /packages/mscomp_*.deb /tmp/
RUN apt-get update \
    && apt-get install -y --no-install-recommends /tmp/mscomp_*.deb \
    && rm -rf /var/lib/apt/lists/* /tmp/mscomp_*.deb
WORKDIR /data
CMD ["mscomp", "--help"]
