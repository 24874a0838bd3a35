# psivox with Mesa's software renderer: docker build -t psivox .
# docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/data" psivox render FILE.vdb -o PICTURE.png
ARG DEBIAN=bookworm
FROM debian:${DEBIAN}-slim AS build
WORKDIR /psivox
COPY tools/install-deps.sh tools/
RUN tools/install-deps.sh
COPY . .
RUN cmake --preset package -DPSIVOX_PYTHON=OFF && cmake --build --preset package && \
    cpack --preset package

FROM debian:${DEBIAN}-slim
COPY --from=build /psivox/build/package/packages/psivox_*.deb /tmp/
RUN apt-get update && \
    apt-get install --yes --no-install-recommends /tmp/psivox_*.deb libgl1-mesa-dri && \
    rm -r /tmp/psivox_*.deb /var/lib/apt/lists/*
WORKDIR /data
ENTRYPOINT ["psivox"]
