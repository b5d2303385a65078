"""The tables of MLflow's database that runs are written to."""

from __future__ import annotations

from sqlalchemy import BigInteger, Boolean, Column, Float, Integer, MetaData, String, Table

#: Revisions of the schema that `DatabaseWriter` is tested with: that of MLflow 3.17.
REVISIONS = frozenset({"dc11669786a5"})

_schema = MetaData()

EXPERIMENTS = Table(
    "experiments",
    _schema,
    Column("experiment_id", Integer, primary_key=True),
    Column("name", String),
    Column("artifact_location", String),
    Column("lifecycle_stage", String),
    Column("creation_time", BigInteger),
    Column("last_update_time", BigInteger),
)
EXPERIMENT_TAGS = Table(
    "experiment_tags", _schema, Column("key", String), Column("value", String), Column("experiment_id", Integer)
)
RUNS = Table(
    "runs",
    _schema,
    Column("run_uuid", String),
    Column("name", String),
    Column("source_type", String),
    Column("source_name", String),
    Column("entry_point_name", String),
    Column("user_id", String),
    Column("status", String),
    Column("start_time", BigInteger),
    Column("end_time", BigInteger),
    Column("source_version", String),
    Column("lifecycle_stage", String),
    Column("artifact_uri", String),
    Column("experiment_id", Integer),
)
TAGS = Table("tags", _schema, Column("key", String), Column("value", String), Column("run_uuid", String))
PARAMS = Table("params", _schema, Column("key", String), Column("value", String), Column("run_uuid", String))
METRICS = Table(
    "metrics",
    _schema,
    Column("key", String),
    Column("value", Float),
    Column("timestamp", BigInteger),
    Column("step", BigInteger),
    Column("is_nan", Boolean),
    Column("run_uuid", String),
)
LATEST_METRICS = METRICS.to_metadata(_schema, name="latest_metrics")
