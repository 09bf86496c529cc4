# Runs the two commands of the README in a bare Debian, as an ordinary user:
#   docker build --tag geoweave . && docker run --rm geoweave
# Notebooks in a browser: docker run --rm --publish 8888:8888 geoweave make lab LABFLAGS="--no-browser --ip=0.0.0.0"
FROM python:3.12-slim-bookworm

# What draws without a screen, what runs the Makefile, and the browser that the tests of pages drive.
RUN apt-get update \
 && apt-get install --yes --no-install-recommends libegl1 libgl1-mesa-dri make git chromium \
 && rm -rf /var/lib/apt/lists/*

RUN useradd --create-home weaver
USER weaver
WORKDIR /home/weaver/geoweave
COPY --chown=weaver . .
RUN make .venv/.complete

CMD ["sh", "-c", "make figures && make test"]
