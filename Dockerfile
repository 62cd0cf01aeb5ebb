# docker build --tag drillid .   and then, in a folder with a configuration:
# docker run --rm --volume "$PWD:$PWD" --workdir "$PWD" drillid drillid run
FROM python:3.11-slim

RUN apt-get update \
 && apt-get install --yes --no-install-recommends make \
 && rm -rf /var/lib/apt/lists/*

WORKDIR /opt/drillid
# the environment is a layer of its own, which an edit of the library leaves alone
COPY Makefile requirements.lock ./
RUN make .venv/ready
COPY . .
RUN make setup

ENV PATH=/opt/drillid/.venv/bin:$PATH
CMD ["drillid", "--help"]
